//! Scenes as dictionaries: Mitsuba's form of a scene in code. Plugins and parameters are those of its XML, and a scene has the
//! same primitives in either form.

use crate::Result;
use crate::scene::description::origin::Origin;
use crate::scene::description::transform::Transform;

/// One object of a scene: its `type`, its parameters and its nested objects, in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dictionary {
    /// Keys with their values.
    pub entries: Vec<(String, Value)>,
}

/// Value of an entry.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A switch.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A word, or the name of a file relative to the current folder.
    Text(String),
    /// A point, a vector, a color, a matrix, pairs of a spectrum, or data of a mesh.
    Array(Array),
    /// A transform.
    Transform(Transform),
    /// A nested object. The types `ref`, `rgb` and `spectrum` are those of Mitsuba.
    Object(Dictionary),
}

/// Numbers in rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Number of values along each axis.
    pub shape: Vec<usize>,
    /// The values; the last axis runs fastest.
    pub values: Vec<f64>,
}

impl Dictionary {
    pub(super) fn get(&self, key: &str) -> Option<&Value> {
        self.entries.iter().find(|(found, _)| found == key).map(|(_, value)| value)
    }

    pub(super) fn text(&self, key: &str, origin: &Origin) -> Result<Option<&str>> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(_) => Err(origin.error(format!("its `{key}` must be a string"))),
        }
    }

    pub(super) fn plugin(&self, origin: &Origin) -> Result<&str> {
        self.text("type", origin)?.ok_or_else(|| origin.error("it needs the entry `type`, the name of a plugin"))
    }

    /// Entries but the type and the id.
    pub(super) fn parameters(&self) -> impl Iterator<Item = &(String, Value)> {
        self.entries.iter().filter(|(key, _)| key != "type" && key != "id")
    }
}
