//! Scene file as a tree that owns its text: defaults substituted, includes spliced in, a line for every node.

use crate::scene::description::origin::{Name, Origin, snake_case};
use crate::{Error, Result};

/// Attributes by their names.
pub(super) type Attributes = Box<[(Name, Box<str>)]>;

/// One XML element. A scene may have millions, so none takes more memory than it needs.
#[derive(Debug)]
pub(super) struct Element {
    pub tag: Name,
    pub attributes: Attributes,
    pub children: Vec<Element>,
    pub location: Origin,
    /// Whether the file is of a version before 2, which is Mitsuba 0.6's format.
    pub is_old: bool,
}

/// Words that stand in almost every element.
const COMMON: [&str; 20] = [
    "name",
    "value",
    "type",
    "id",
    "x",
    "y",
    "z",
    "ref",
    "shape",
    "transform",
    "translate",
    "scale",
    "rotate",
    "angle",
    "matrix",
    "string",
    "float",
    "boolean",
    "bsdf",
    "rgb",
];

/// A tag or the name of an attribute. Common ones take no memory of their own.
pub(super) fn word(word: &str) -> Name {
    let common = COMMON.into_iter().find(|common| *common == word);
    common.map_or_else(|| word.to_owned().into(), Name::from)
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| &**value)
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
