//! The arguments that the table of options makes: one for each option that sets one setting.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use lodestar::Result;
use lodestar::settings::Settings;
use lodestar::settings::options::{self, Audience, Category, OPTIONS, OptionEntry};

/// Values of options that were given, as text. With `ONLY_GUIDES` these are the options of the category `Guiding`, otherwise all
/// options of the table.
#[derive(Debug)]
pub struct SettingArgs<const ONLY_GUIDES: bool> {
    given: Vec<(&'static OptionEntry, String)>,
}

impl<const ONLY_GUIDES: bool> SettingArgs<ONLY_GUIDES> {
    fn options() -> impl Iterator<Item = &'static OptionEntry> {
        let is_wanted = |option: &&OptionEntry| !ONLY_GUIDES || option.category == Category::Guiding;
        OPTIONS.iter().filter(|option| option.set().is_some()).filter(is_wanted)
    }

    /// Changes `settings` as the arguments say.
    pub fn apply(&self, settings: &mut Settings) {
        for (option, text) in &self.given {
            // The parser has refused every wrong text, so this cannot fail.
            let _ = option.set().map(|set| set(settings, text));
        }
    }

    /// Refuses arguments that have no effect on `settings`.
    ///
    /// # Errors
    /// [`lodestar::Error::Settings`], naming the option and the samplers that use it.
    pub fn check_uses(&self, settings: &Settings) -> Result<()> {
        options::check_given(settings, &|name| self.text(name).is_some())
    }

    /// Value that was given for the option `name`.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.given.iter().find(|(option, _)| option.name == name).map(|(_, text)| &text[..])
    }
}

impl<const ONLY_GUIDES: bool> FromArgMatches for SettingArgs<ONLY_GUIDES> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given =
            Self::options().filter_map(|option| Some((option, matches.get_one::<String>(option.name)?.clone())));
        Ok(Self { given: given.collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<const ONLY_GUIDES: bool> Args for SettingArgs<ONLY_GUIDES> {
    fn augment_args(command: Command) -> Command {
        command.args(Self::options().map(argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

fn argument(option: &'static OptionEntry) -> Arg {
    let parser = move |text: &str| options::check_text(option, text).map(|()| text.to_owned());
    Arg::new(option.name).long(option.name).value_parser(parser)
}

/// Options of `lodestar resume` whose default is what the checkpoint holds.
const KEPT_BY_CHECKPOINT: [&str; 5] = ["output", "tone", "exposure", "spp", "traversal"];
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
    let is_kept = subcommand == "resume" && KEPT_BY_CHECKPOINT.contains(&option.name);
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

    /// The table has exactly the options of `render`, and their help comes from the table.
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
        for option in OPTIONS {
            assert!(options.iter().any(|argument| entry_of(argument).is_some_and(|entry| entry.name == option.name)));
        }
    }
}
