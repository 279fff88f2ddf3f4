//! The arguments that the table of options makes: one for each option that a subcommand takes.

use std::ffi::{OsStr, OsString};
use std::marker::PhantomData;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Args, Command, FromArgMatches, ValueHint, value_parser};
use lodestar::Result;
use lodestar::settings::Settings;
use lodestar::settings::options::{self, Audience, Category, Form, OPTIONS, OptionEntry, Resume};

/// Options that a subcommand takes.
pub trait Subset: Send + Sync + 'static {
    /// Whether an option is one of them.
    fn has(option: &OptionEntry) -> bool;
}

/// Options of `lodestar render`: all of them.
#[derive(Debug)]
pub struct OfRender;

/// Options of `lodestar resume`.
#[derive(Debug)]
pub struct OfResume;

/// Options of `lodestar radiance`: those that decide the scene and the settings, and the device.
#[derive(Debug)]
pub struct OfMap;

/// Options of `lodestar view` for a scene: those that decide the scene and the settings, its length, the device and the picture.
#[derive(Debug)]
pub struct OfView;

/// Options of `lodestar layers`: those that decide the scene and the film, and the device.
#[derive(Debug)]
pub struct OfLayers;

/// Options that choose a guide.
#[derive(Debug)]
pub struct OfGuide;

impl Subset for OfRender {
    fn has(_: &OptionEntry) -> bool {
        true
    }
}

impl Subset for OfResume {
    fn has(option: &OptionEntry) -> bool {
        option.resume != Resume::Fixed
    }
}

impl Subset for OfMap {
    fn has(option: &OptionEntry) -> bool {
        let is_of_picture = matches!(option.category, Category::Scene | Category::Paths | Category::Guiding);
        is_of_picture || option.set().is_some() || option.name == "device"
    }
}

impl Subset for OfView {
    fn has(option: &OptionEntry) -> bool {
        let others =
            ["width", "height", "scale", "rfilter", "spp", "output", "guide", "oidn", "oidn-device", "slice-ms"];
        OfMap::has(option) || others.contains(&option.name)
    }
}

impl Subset for OfLayers {
    fn has(option: &OptionEntry) -> bool {
        let others = ["rfilter", "seed", "hide-emitters", "device", "traversal", "overwrite"];
        option.category == Category::Scene && option.name != "environment" || others.contains(&option.name)
    }
}

impl Subset for OfGuide {
    fn has(option: &OptionEntry) -> bool {
        option.category == Category::Guiding
    }
}

/// Options of a subset that were given, with their values as they were written. A switch has none.
#[derive(Debug)]
pub struct Given<S: Subset> {
    values: Vec<(&'static OptionEntry, Vec<OsString>)>,
    subset: PhantomData<S>,
}

impl<S: Subset> Given<S> {
    fn options() -> impl Iterator<Item = &'static OptionEntry> {
        OPTIONS.iter().filter(|option| S::has(option))
    }

    fn all(&self, name: &str) -> &[OsString] {
        let found = self.values.iter().find(|(option, _)| option.name == name);
        found.map_or(&[], |(_, values)| values)
    }

    /// Name of an option that was given, if there is one.
    pub fn first(&self) -> Option<&'static str> {
        self.values.first().map(|(option, _)| option.name)
    }

    /// Whether the option `name` was given.
    pub fn has(&self, name: &str) -> bool {
        self.values.iter().any(|(option, _)| option.name == name)
    }

    /// Value that was given for the option `name`.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.all(name).first().and_then(|value| value.to_str())
    }

    /// Path that was given for the option `name`.
    pub fn path(&self, name: &str) -> Option<PathBuf> {
        self.all(name).first().map(PathBuf::from)
    }

    /// What `read` makes of the value of the option `name`. The parser has refused every text of which it makes nothing.
    pub fn value<T, E>(&self, name: &str, read: impl Fn(&str) -> Result<T, E>) -> Option<T> {
        self.text(name).and_then(|text| read(text).ok())
    }

    /// What `read` makes of every value of the option `name`.
    pub fn values<T, E>(&self, name: &str, read: impl Fn(&str) -> Result<T, E>) -> Vec<T> {
        self.all(name).iter().filter_map(|value| read(value.to_str()?).ok()).collect()
    }

    /// Word that was given for the option `name`.
    pub fn word<T: clap::ValueEnum>(&self, name: &str) -> Option<T> {
        self.value(name, |text| T::from_str(text, false))
    }

    /// Changes `settings` as the options say that set one setting each.
    pub fn apply(&self, settings: &mut Settings) {
        for (option, set) in self.values.iter().filter_map(|(option, _)| Some((option, option.set()?))) {
            // The parser has refused every wrong text, so this cannot fail.
            let _ = self.text(option.name).map(|text| set(settings, text));
        }
    }

    /// Refuses options that have no effect on `settings`.
    ///
    /// # Errors
    /// [`lodestar::Error::Settings`], naming the option and the samplers that use it.
    pub fn check_uses(&self, settings: &Settings) -> Result<()> {
        options::check_given(settings, &|name| self.has(name))
    }
}

impl<S: Subset> FromArgMatches for Given<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let values_of = |option: &OptionEntry| match option.form {
            Form::Switch => matches.get_flag(option.name).then(Vec::new),
            _ => matches.get_raw(option.name).map(|values| values.map(OsStr::to_owned).collect()),
        };
        let values = Self::options().filter_map(|option| Some((option, values_of(option)?))).collect();
        Ok(Self { values, subset: PhantomData })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<S: Subset> Args for Given<S> {
    fn augment_args(command: Command) -> Command {
        let command = command.args(Self::options().map(argument::<S>));
        let several = Self::options().map(|option| option.requires).find(|others| others.len() > 1);
        let group = several.map(|others| ArgGroup::new(ONE_OF_SEVERAL).args(others).multiple(true));
        command.groups(group)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Name of the group of options of which one must stand beside some others. The table has one such group.
const ONE_OF_SEVERAL: &str = "one of several";

fn argument<S: Subset>(option: &'static OptionEntry) -> Arg {
    let check = move |text: &str| options::check_text(option, text).map(|()| text.to_owned());
    let argument = Arg::new(option.name);
    let argument = if option.has_long_name() { argument.long(option.name) } else { argument };
    let argument = option.letter.into_iter().fold(argument, Arg::short);
    let argument = match option.form {
        Form::Switch => argument.action(ArgAction::SetTrue),
        Form::OneOf(words) => argument.value_parser(PossibleValuesParser::new(words)),
        Form::Path => argument.value_parser(value_parser!(PathBuf)).value_hint(ValueHint::AnyPath),
        Form::Setting | Form::Text { .. } => argument.value_parser(check),
    };
    let argument = if option.repeats { argument.action(ArgAction::Append) } else { argument };
    // A list of numbers may begin with a minus.
    let argument = if option.value_name.contains(',') { argument.allow_hyphen_values(true) } else { argument };
    let argument = match option.bare {
        "" => argument,
        bare => argument.num_args(0..=1).default_missing_value(bare),
    };
    let is_taken = |name: &&str| options::find(name).is_some_and(S::has);
    let argument = match option.requires {
        [] => argument,
        [other] if !is_taken(other) => argument,
        [other] => argument.requires(*other),
        _ => argument.requires(ONE_OF_SEVERAL),
    };
    let argument = argument.conflicts_with_all(option.excludes.iter().copied().filter(is_taken));
    if option.variable.is_empty() { argument } else { argument.env(option.variable) }
}

/// Options of a picture's settings that `lodestar radiance` refuses, with values that have no meaning for a map.
const NOT_FOR_MAPS: [&str; 3] = ["steps", "sample-weights", "nee"];

/// `command` with the table's help for every argument that has none of its own.
pub fn described(command: Command) -> Command {
    let names: Vec<_> = command.get_subcommands().map(|subcommand| subcommand.get_name().to_owned()).collect();
    let describe = |command: Command, name: String| {
        let of = name.clone();
        command
            .mut_subcommand(name, move |subcommand| subcommand.mut_args(|argument| described_argument(&of, argument)))
    };
    names.into_iter().fold(command, describe)
}

fn described_argument(subcommand: &str, argument: Arg) -> Arg {
    let Some(option) = entry_of(&argument).filter(|_| argument.get_help().is_none()) else { return argument };
    let is_kept = subcommand == "resume" && option.resume == Resume::Kept;
    let default = is_kept.then_some("as in the checkpoint");
    let has_heading = argument.get_help_heading().is_some();
    let argument = argument.help(option.short_help(default)).long_help(option.long_help(default));
    let argument = if has_heading { argument } else { argument.help_heading(option.heading()) };
    let argument = argument.hide(subcommand == "radiance" && NOT_FOR_MAPS.contains(&option.name));
    let argument = argument.hide_short_help(option.audience != Audience::Everyone);
    let argument = argument.hide_default_value(true).hide_possible_values(true).hide_env(true);
    if option.value_name.is_empty() { argument } else { argument.value_name(option.value_name) }
}

/// Entry of the table for an argument.
fn entry_of(argument: &Arg) -> Option<&'static OptionEntry> {
    match (argument.get_long(), argument.get_short()) {
        (Some(name), _) => options::find(name),
        (None, Some(letter)) => options::find(letter.encode_utf8(&mut [0; 4])),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::command;

    /// Render has exactly the options of the table, and their help comes from the table.
    #[test]
    fn the_options_of_render_are_those_of_the_table() {
        let command = command();
        let render = command.find_subcommand("render").expect("a subcommand");
        let options: Vec<_> = render.get_opts().filter(|argument| argument.get_id() != "help").collect();
        for argument in &options {
            let entry = entry_of(argument).unwrap_or_else(|| panic!("{argument} has no entry"));
            let long_help = argument.get_long_help().map(ToString::to_string);
            assert_eq!(long_help.as_deref(), Some(&entry.long_help(None)[..]), "{argument}");
        }
        let several: Vec<_> = OPTIONS.iter().map(|option| option.requires).filter(|others| others.len() > 1).collect();
        assert!(several.iter().all(|others| *others == several[0]), "given.rs makes one group");
        for option in OPTIONS {
            assert!(options.iter().any(|argument| entry_of(argument).is_some_and(|entry| entry.name == option.name)));
        }
    }

    /// The names in an entry are in the table, and words that are read as a type are that type's.
    #[test]
    fn entries_agree_with_each_other_and_with_types() {
        for option in OPTIONS {
            for other in option.requires.iter().chain(option.excludes) {
                assert!(options::find(other).is_some(), "{}: {other}", option.name);
            }
            assert!(!matches!(option.form, Form::Setting) || option.set().is_some(), "{}", option.name);
            assert_eq!(matches!(option.form, Form::Switch), option.value_name.is_empty(), "{}", option.name);
        }
        fn words<T: clap::ValueEnum>() -> Vec<String> {
            let values = T::value_variants().iter().filter_map(T::to_possible_value);
            values.map(|value| value.get_name().to_owned()).collect()
        }
        for (name, expected) in [
            ("execution", words::<lodestar::settings::Execution>()),
            ("traversal", words::<lodestar::settings::Traversal>()),
            ("tone", words::<lodestar::image::ToneCurve>()),
            ("oidn-device", words::<lodestar::denoise::DeviceKind>()),
            ("log", words::<crate::cli::render_args::LogFormat>()),
            ("rfilter", words::<crate::cli::render_args::Filter>()),
        ] {
            let Some(Form::OneOf(found)) = options::find(name).map(|option| option.form) else { panic!("{name}") };
            assert_eq!(found, expected, "{name}");
        }
    }
}
