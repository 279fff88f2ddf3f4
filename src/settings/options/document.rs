//! Writer of `docs/options.md`, from the table of options.

use std::fmt::Write;

use super::entry::{Audience, Category, OptionEntry, RESEARCH};
use super::table::OPTIONS;
use crate::settings::value::Word;

/// Text of `docs/options.md`.
pub fn document() -> String {
    let mut text = String::from(
        "# Options of `lodestar render`\n\n\
         For everybody who has a scene and wants another picture of it than the default's.\n\n\
         This page is written from the table in `src/settings/options/table.rs`, and a test holds it to that table.\n\
         `lodestar render -h` shows the options marked with *; `lodestar render --help` shows all of them.\n",
    );
    let headings = Category::ALL.map(Category::heading);
    for heading in headings.into_iter().chain([RESEARCH]) {
        let mut options = OPTIONS.iter().filter(|option| option.heading() == heading).peekable();
        if options.peek().is_some() {
            text += &format!("\n## {heading}\n");
            options.for_each(|option| text += &section(option));
        }
    }
    text
}

fn section(option: &OptionEntry) -> String {
    let letter = option.letter.filter(|_| option.has_long_name());
    let letter = letter.map_or_else(String::new, |letter| format!("`-{letter}`, "));
    let mark = if option.audience == Audience::Everyone { " *" } else { "" };
    let mut text = format!("\n### {letter}`{}`{mark}\n", option.usage());
    let long = if option.long.is_empty() { String::new() } else { format!(" {}", option.long) };
    text += &format!("{}.{long}\n", option.short);
    let facts = [default_fact(option), range_fact(option)].into_iter().flatten();
    let rules = option.rules.iter().map(|rule| format!("`{}` {}.", rule.when.option_text(option.name), rule.words()));
    let words = option.words().into_iter().filter(|word| !word.help.is_empty());
    let words = words.map(|Word { name, help }| format!("`{name}`: {}", with_period(&help)));
    let lines: Vec<_> = words.chain(facts).chain(rules).collect();
    if !lines.is_empty() {
        text += "\n";
    }
    for line in lines {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "- {line}");
    }
    text
}

fn default_fact(option: &OptionEntry) -> Option<String> {
    let default = option.default_text();
    (!default.is_empty()).then(|| format!("Default: {default}."))
}

fn range_fact(option: &OptionEntry) -> Option<String> {
    let (least, most) = option.range?;
    Some(format!("Range: {least} to {most}."))
}

fn with_period(text: &str) -> String {
    format!("{}.", text.trim_end_matches('.'))
}

impl OptionEntry {
    /// Whether the name is longer than a letter.
    pub fn has_long_name(&self) -> bool {
        self.name.len() > 1
    }

    /// Option with its value, as it is written.
    pub fn usage(&self) -> String {
        let dashes = if self.has_long_name() { "--" } else { "-" };
        match self.value_name {
            "" => format!("{dashes}{}", self.name),
            value => format!("{dashes}{} {value}", self.name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::options::defaults;
    use crate::settings::{Settings, Value};

    #[test]
    fn every_option_is_described_once_and_shortly() {
        for (at, option) in OPTIONS.iter().enumerate() {
            assert!(OPTIONS[..at].iter().all(|other| other.name != option.name), "{}", option.name);
            assert!(!option.short.is_empty() && option.short.len() <= 60, "{}: {}", option.name, option.short);
            assert!(!option.short.ends_with('.'), "{}", option.name);
            assert!(option.long.is_empty() || option.long.ends_with('.'), "{}", option.name);
            assert!(option.category != Category::Guiding || option.setting.is_some(), "{}", option.name);
            // Only a number that the scene may decide has its default in words.
            let is_number = |get: fn(&Settings) -> Value| matches!(get(&defaults()), Value::Number(_));
            let has_number = option.set().is_some() && option.setting.is_some_and(|setting| is_number(setting.get));
            assert!(option.default.is_empty() || !has_number, "{}", option.name);
        }
    }
}
