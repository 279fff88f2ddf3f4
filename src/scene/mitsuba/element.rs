//! Scene file as a tree that owns its text: defaults substituted, includes spliced in, a line for every node.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use crate::{Error, Result};

/// Elements that make a plugin: they have a `type` and may have an `id`.
pub(super) const OBJECT_TAGS: [&str; 12] = [
    "bsdf",
    "emitter",
    "film",
    "integrator",
    "medium",
    "phase",
    "rfilter",
    "sampler",
    "sensor",
    "shape",
    "subsurface",
    "texture",
];

/// Elements that give a plugin a parameter.
pub(super) const PARAMETER_TAGS: [&str; 12] = [
    "animation",
    "blackbody",
    "boolean",
    "float",
    "integer",
    "point",
    "rgb",
    "spectrum",
    "srgb",
    "string",
    "transform",
    "vector",
];

/// Plugin of a shape whose mesh lies in memory. Only dictionaries and descriptions have it.
pub(in crate::scene) const MESH: &str = "mesh";

/// Parameter of such a shape: the index of its mesh.
pub(in crate::scene) const MESH_INDEX: &str = "mesh_index";

/// Line of a scene file, or an entry of a dictionary.
#[derive(Debug, Clone)]
pub(super) struct Location {
    /// Path of the file, or the entry's keys such as `scene.box.bsdf`.
    pub file: Arc<Path>,
    /// Line of the file, counted from 1; `None` for an entry of a dictionary.
    pub line: Option<u32>,
}

impl Location {
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::scene(&self.file, self.line, message)
    }

    /// The line alone, or the entry, for names of things that have none.
    pub fn brief(&self) -> String {
        self.line.map_or_else(|| self.file.display().to_string(), |line| format!("line {line}"))
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.file.display()),
            None => write!(f, "{}", self.file.display()),
        }
    }
}

/// One XML element, or one entry of a dictionary.
#[derive(Debug)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub location: Location,
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
        self.attribute("name").map(snake_case)
    }

    /// Name of the plugin: the attribute `type`.
    pub fn plugin(&self) -> Result<&str> {
        self.required("type")
    }

    pub fn is_object(&self) -> bool {
        OBJECT_TAGS.contains(&self.tag.as_str())
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        self.location.error(message)
    }

    /// Error for a plugin that this loader does not support.
    pub fn unsupported(&self, supported: &[&str]) -> Error {
        let plugin = self.attribute("type").unwrap_or_default();
        let list = supported.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        self.error(format!("{} plugin `{plugin}` is not supported; use one of {list}", self.tag))
    }
}

/// Name in snake_case: `toWorld` becomes `to_world`, `intIOR` becomes `int_ior`.
fn snake_case(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let mut after_lower = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() && after_lower {
            result.push('_');
        }
        after_lower = c.is_ascii_lowercase() || c.is_ascii_digit();
        result.push(c.to_ascii_lowercase());
    }
    result
}

#[cfg(test)]
mod tests {
    use super::snake_case;

    #[test]
    fn both_spellings_give_one_key() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("rrDepth", "rr_depth"),
            ("intIOR", "int_ior"),
            ("principalPointOffsetX", "principal_point_offset_x"),
            ("fov", "fov"),
            ("crop_offset_x", "crop_offset_x"),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }
}
