//! Scene file as a tree that owns its text: defaults substituted, includes spliced in, a line for every node.

use crate::scene::description::origin::{Origin, snake_case};
use crate::{Error, Result};

/// One XML element.
#[derive(Debug)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub location: Origin,
    /// Whether the file is of a version before 2, which is Mitsuba 0.6's format.
    pub is_old: bool,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    pub fn required(&self, name: &str) -> Result<&str> {
        self.attribute(name).ok_or_else(|| self.error(format!("<{}> lacks its attribute `{name}`", self.tag)))
    }

    /// Name of the parameter in snake_case, however the file spells it.
    pub fn key(&self) -> Option<String> {
        self.attribute("name").map(|name| snake_case(name).into_owned())
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        self.location.error(message)
    }
}
