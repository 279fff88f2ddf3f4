//! Scenes as dictionaries: Mitsuba's form of a scene in code. Plugins and parameters are those of its XML, and a scene has the
//! same primitives in either form.

use std::path::Path;
use std::sync::Arc;

use super::element::{Element, Location};
use super::transform;
use crate::Result;

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

/// A transform as a chain of operations, as a scene file writes it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Transform {
    /// The operations; the first is applied first.
    pub operations: Vec<Operation>,
}

/// One operation of a transform.
#[derive(Debug, Clone, PartialEq)]
pub enum Operation {
    /// A translation by a vector.
    Translate([f64; 3]),
    /// A scale by a factor along each axis.
    Scale([f64; 3]),
    /// A rotation about an axis, by an angle in degrees.
    Rotate {
        /// Axis. Its length should be 1: as in Mitsuba 3, another length scales, too.
        axis: [f64; 3],
        /// Angle in degrees, counterclockwise where the axis points to the viewer.
        degrees: f64,
    },
    /// A camera's place: `+z` looks from the origin to the target, `+x` points to the left of the picture.
    LookAt {
        /// Position of the camera.
        origin: [f64; 3],
        /// Point that the camera looks at.
        target: [f64; 3],
        /// Direction that points up in the picture.
        up: [f64; 3],
    },
    /// A matrix of four rows. The last row is 0 0 0 1.
    Matrix([f64; 16]),
}

impl Transform {
    /// Product of the operations, to the last bit as the reader of scenes computes it. The columns are those of `DMat4`.
    ///
    /// # Errors
    /// Where a number is not finite, an axis is zero, or a camera looks along its `up`.
    pub fn matrix(&self) -> Result<[f64; 16]> {
        let element = self.element("transform", &at("transform"));
        Ok(transform::parse(&element)?.to_cols_array())
    }

    pub(super) fn element(&self, name: &str, location: &Location) -> Element {
        let children = self.operations.iter().map(|operation| operation.element(location)).collect();
        Element { children, ..leaf("transform", [("name", name.to_owned())], location) }
    }
}

impl Operation {
    fn element(&self, location: &Location) -> Element {
        match self {
            Self::Translate(by) => leaf("translate", [("value", joined(by))], location),
            Self::Scale(by) => leaf("scale", [("value", joined(by))], location),
            Self::Rotate { axis, degrees } => {
                leaf("rotate", [("value", joined(axis)), ("angle", number(*degrees))], location)
            }
            Self::LookAt { origin, target, up } => {
                let attributes = [("origin", joined(origin)), ("target", joined(target)), ("up", joined(up))];
                leaf("lookat", attributes, location)
            }
            Self::Matrix(rows) => leaf("matrix", [("value", joined(rows))], location),
        }
    }
}

impl Dictionary {
    pub(super) fn get(&self, key: &str) -> Option<&Value> {
        self.entries.iter().find(|(found, _)| found == key).map(|(_, value)| value)
    }

    pub(super) fn text(&self, key: &str, location: &Location) -> Result<Option<&str>> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(_) => Err(location.error(format!("its `{key}` must be a string"))),
        }
    }

    pub(super) fn plugin(&self, location: &Location) -> Result<&str> {
        self.text("type", location)?.ok_or_else(|| location.error("it needs the entry `type`, the name of a plugin"))
    }
}

/// Location of an entry.
pub(super) fn at(path: &str) -> Location {
    Location { file: Arc::from(Path::new(path)), line: None }
}

/// Element without children.
pub(super) fn leaf<const N: usize>(tag: &str, attributes: [(&str, String); N], location: &Location) -> Element {
    Element {
        tag: tag.to_owned(),
        attributes: attributes.map(|(name, value)| (name.to_owned(), value)).into(),
        children: Vec::new(),
        location: location.clone(),
        is_old: false,
    }
}

/// Text of a number that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Text of numbers, with spaces between them.
pub(super) fn joined(values: &[f64]) -> String {
    values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(" ")
}
