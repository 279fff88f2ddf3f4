//! Entry of the table: one option with its help, range and rules.

use super::form::Form;
use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};
use crate::settings::flat::Settings;
use crate::settings::sampler::{Learner, Sampler};
use crate::settings::value::{Value, Word};

/// One option of the command line.
#[derive(Debug)]
pub struct OptionEntry {
    /// Name without the dashes.
    pub name: &'static str,
    /// Placeholder for the value in the help.
    pub value_name: &'static str,
    /// Subject of the option.
    pub category: Category,
    /// Readers that the option is for.
    pub audience: Audience,
    /// Help on one line of at most 60 characters.
    pub short: &'static str,
    /// Further help, which follows the short help.
    pub long: &'static str,
    /// Default in words. If it is empty, the default settings have the default.
    pub default: &'static str,
    /// Value that it takes.
    pub form: Form,
    /// Letter of the short form, if there is one.
    pub letter: Option<char>,
    /// Whether it may be given several times.
    pub repeats: bool,
    /// Value where it is given without one; empty where that is an error.
    pub bare: &'static str,
    /// Options of which one must be given beside it; empty where it may stand alone.
    pub requires: &'static [&'static str],
    /// Options beside which it is refused.
    pub excludes: &'static [&'static str],
    /// Environment variable with the default; empty where there is none.
    pub variable: &'static str,
    /// Part that it has in `lodestar resume`.
    pub resume: Resume,
    /// Functions of Python that have it as a keyword.
    pub keyword: Keyword,
    /// Least and largest number.
    pub range: Option<(f64, f64)>,
    /// Combinations that the option allows.
    pub rules: &'static [Rule],
    /// Setting that the option sets, if it sets one.
    pub setting: Option<Setting>,
}

/// Subject of an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    /// The scene and the film.
    Scene,
    /// Files and messages.
    Output,
    /// Length of the render.
    Length,
    /// Paths and their random numbers.
    Paths,
    /// Sampling and learning of directions. Every option of this category sets one setting.
    Guiding,
    /// The device and its kernels.
    Device,
}

/// Part of an option in `lodestar resume`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resume {
    /// None: the checkpoint holds what was chosen.
    Fixed,
    /// The option is taken. Its default is what the checkpoint holds.
    Kept,
    /// The option is taken, with its own default.
    Free,
}

/// Functions of Python that have an option as a keyword.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keyword {
    /// None.
    Nowhere,
    /// A new render.
    Render,
    /// A new render and a resumed one.
    RenderAndResume,
}

/// Readers that an option is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Audience {
    /// Everyone: `-h` shows the option.
    Everyone,
    /// Readers of `--help`.
    Curious,
    /// Researchers: `--help` shows the option under a heading of its own.
    Researchers,
}

/// Heading of the options for researchers.
pub const RESEARCH: &str = "Research";

/// Function that sets a setting to the value that a text stands for.
pub type Set = fn(&mut Settings, &str) -> Result<(), String>;

/// Access to one setting.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Value of the setting.
    pub get: fn(&Settings) -> Value,
    /// Sets the setting to the value that a text stands for. `None` where the command line reads the option in another way.
    pub set: Option<Set>,
    /// Words that the setting takes; none where it takes numbers.
    pub words: fn() -> Vec<Word>,
    /// Type of a number in Python.
    pub python: &'static str,
}

/// Condition on an option.
#[derive(Debug)]
pub struct Rule {
    /// Values that the rule is about.
    pub when: When,
    /// Condition that must hold for these values.
    pub needs: Needs,
    /// Reason in one clause; it may be empty.
    pub reason: &'static str,
    /// Whether the rule holds for all settings. A rule that does not refuses only an option that was given on the command line:
    /// the settings are legal, but the option has no effect.
    pub always: bool,
}

/// Values that a rule is about.
#[derive(Debug, Clone, Copy)]
pub enum When {
    /// Any value.
    Any,
    /// One word.
    Word(&'static str),
    /// Numbers above 0.
    AboveZero,
}

/// Condition that a rule states.
#[derive(Debug, Clone, Copy)]
pub enum Needs {
    /// One of these samplers.
    Samplers(&'static [Sampler]),
    /// One of these learners.
    Learners(&'static [Learner]),
    /// Absence of another option.
    Without(&'static str, fn(&Settings) -> bool),
    /// Values of settings, described in words.
    Value(&'static str, fn(&Settings) -> bool),
}

impl OptionEntry {
    /// Heading of the option in the help.
    pub fn heading(&self) -> &'static str {
        match (self.audience, self.category) {
            (Audience::Researchers, _) => RESEARCH,
            (_, category) => category.heading(),
        }
    }

    /// Short help with the default: `default`, or without it that of a new render.
    pub fn short_help(&self, default: Option<&str>) -> String {
        match default.map_or_else(|| self.default_text(), str::to_owned) {
            default if default.is_empty() => self.short.to_owned(),
            default => format!("{} [default: {default}]", self.short),
        }
    }

    /// Long help with the words that the option takes and the default: `default`, or without it that of a new render.
    pub fn long_help(&self, default: Option<&str>) -> String {
        let mut text = format!("{}.", self.short);
        if !self.long.is_empty() {
            text += &format!(" {}", self.long);
        }
        let words = self.words();
        if words.iter().any(|word| !word.help.is_empty()) {
            text += "\n\nValues:";
            for Word { name, help } in words {
                text += &format!("\n- {name}: {}", help.trim_end_matches('.'));
            }
        }
        match default.map_or_else(|| self.default_text(), str::to_owned) {
            default if default.is_empty() => text,
            default => format!("{text}\n\n[default: {default}]"),
        }
    }

    /// Function that sets the option's setting from text alone, if there is one.
    pub fn set(&self) -> Option<Set> {
        self.setting.and_then(|setting| setting.set)
    }

    /// Words that the option takes; none where it takes something else.
    pub fn words(&self) -> Vec<Word> {
        self.setting.map_or_else(Vec::new, |setting| (setting.words)())
    }

    /// Type of the keyword in Python, as the stub writes it.
    pub fn python_type(&self) -> String {
        let literal = |words: Vec<String>| format!("Literal[{}]", words.join(", "));
        let quoted = |word: &str| format!("\"{word}\"");
        match (self.form, self.setting) {
            (Form::Switch, _) => "bool".into(),
            (Form::Path, _) => "_Path".into(),
            (Form::Text { python, .. }, _) => python.into(),
            (Form::OneOf(words), _) => literal(words.iter().map(|word| quoted(word)).collect()),
            (Form::Setting, setting) => {
                let words: Vec<_> = self.words().iter().map(|word| quoted(&word.name)).collect();
                let number = setting.map_or("str", |setting| setting.python);
                match (words.is_empty(), number) {
                    (true, number) => number.into(),
                    (false, "bool") => format!("bool | {}", literal(words)),
                    (false, _) => literal(words),
                }
            }
        }
    }

    /// Default as text; empty where there is none.
    pub fn default_text(&self) -> String {
        if !self.default.is_empty() {
            return self.default.to_owned();
        }
        match self.setting.map(|setting| (setting.get)(&defaults())) {
            Some(Value::Nothing) | None => String::new(),
            Some(value) => value.to_string(),
        }
    }
}

impl Category {
    /// Every category, in the order of the help.
    pub const ALL: [Self; 6] = [Self::Scene, Self::Output, Self::Length, Self::Paths, Self::Guiding, Self::Device];

    /// Heading of the category.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Output => "Output",
            Self::Length => "Length",
            Self::Paths => "Paths",
            Self::Guiding => "Guiding",
            Self::Device => "Device",
        }
    }
}

/// Refuses a text that is no value of the option. Words are not checked here: whoever reads the option lists them.
///
/// # Errors
/// The expected form of the value.
pub fn check_text(option: &OptionEntry, text: &str) -> Result<(), String> {
    match option.form {
        Form::Setting => option.set().map_or(Ok(()), |set| set(&mut defaults(), text)),
        Form::Text { check, .. } => check(text),
        Form::Switch | Form::OneOf(_) | Form::Path => Ok(()),
    }
}

/// Settings of a film of any size.
pub fn defaults() -> Settings {
    let film = FilmDescription { width: 1, height: 1, crop: None, filter: ReconstructionFilter::Box };
    Settings::for_film(&film, &IntegratorDescription::default())
}
