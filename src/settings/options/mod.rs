//! The table of options. One entry says everything about one option: its name, its help, its range, and the samplers, learners
//! and other options that it fits. The command line's help, its checks and `docs/options.md` come from the table.

mod check;
mod document;
mod duration;
mod entry;
pub mod form;
mod other_names;
mod table;

pub use check::{check, check_given};
pub use document::document;
pub use duration::seconds;
pub use entry::{
    Audience, Category, Keyword, Needs, OptionEntry, RESEARCH, Resume, Rule, Set, Setting, When, check_text, defaults,
};
pub use form::Form;
pub use other_names::meaning;
pub use table::{LOCAL, OPTIONS};

/// Entry of the option with this name.
pub fn find(name: &str) -> Option<&'static OptionEntry> {
    OPTIONS.iter().find(|option| option.name == name)
}
