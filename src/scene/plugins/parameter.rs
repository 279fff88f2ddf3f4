//! One parameter of a plugin.

use crate::scene::description::kinds::Type;
use crate::scene::description::object::{Entry, Fault, Object, Value};
use crate::scene::description::origin::Origin;
use crate::scene::description::transform::finite;
use crate::{Error, Result};

/// Parameter of an object.
#[derive(Clone, Copy)]
pub(super) struct Parameter<'a> {
    pub owner: &'a Object,
    pub entry: &'a Entry,
}

impl<'a> Parameter<'a> {
    pub fn value(&self) -> &'a Value {
        &self.entry.value
    }

    pub fn origin(&self) -> Origin {
        self.owner.origin_of(self.entry)
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        self.origin().error(message)
    }

    /// Text of a string; empty for another value.
    pub fn text(&self) -> &'a str {
        match &self.entry.value {
            Value::Text(text) => text,
            Value::Image(image) => &image.name,
            _ => "",
        }
    }

    /// The number.
    pub fn number(&self) -> Result<f64> {
        match &self.entry.value {
            Value::Float(value) => finite(*value).map_err(|message| self.error(message)),
            Value::Integer(value) => Ok(*value as f64),
            Value::Fault(fault) => Err(self.fault(fault)),
            _ => Err(self.mismatch(Type::Float.name(), &self.entry.name)),
        }
    }

    /// Three finite numbers.
    pub fn three(&self) -> Result<[f64; 3]> {
        match &self.entry.value {
            Value::Point(given) | Value::Vector(given) | Value::Rgb(given) | Value::Srgb(given) => self.finite(given),
            Value::Array(given) => {
                let text = given.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" ");
                Err(self.error(format!("`{text}` should be three numbers")))
            }
            _ => Err(self.mismatch(Type::Vector.name(), &self.entry.name)),
        }
    }

    /// The numbers, if all are finite.
    pub fn finite<const N: usize>(&self, numbers: &[f64; N]) -> Result<[f64; N]> {
        numbers.iter().try_for_each(|number| finite(*number).map(drop)).map_err(|message| self.error(message))?;
        Ok(*numbers)
    }

    /// Error for a value that the front end could not read.
    pub fn fault(&self, fault: &Fault) -> Error {
        fault.origin.as_ref().unwrap_or(&self.origin()).error(&fault.message)
    }

    /// Error for a parameter of another type than `wanted`.
    pub fn mismatch(&self, wanted: &str, name: &str) -> Error {
        let origin = self.origin();
        let found = match self.entry.value.type_of() {
            Some(found) => found.name(),
            None => "mesh",
        };
        let (wanted, found) = (origin.word(wanted), origin.word(found));
        origin.error(format!("the parameter `{name}` should be a {wanted}, not a {found}"))
    }
}
