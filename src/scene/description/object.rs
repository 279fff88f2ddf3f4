//! Objects: plugins with typed parameters and nested objects.

use std::borrow::Cow;
use std::sync::Arc;

use super::kinds::{Kind, Type};
use super::origin::{Name, Origin, snake_case};
use super::transform::Transform;
use crate::Error;
use crate::scene::grids::Grid;
use crate::scene::mesh::Mesh;

/// Parameter under which an object has its mesh in memory, and the plugin of that object.
pub(in crate::scene) const MESH: &str = "mesh";

/// One plugin: its parameters and nested objects, in order.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Object {
    pub kind: Kind,
    /// Name of the plugin.
    pub plugin: Name,
    /// Name by which others refer to it.
    pub id: Option<String>,
    pub entries: Vec<Entry>,
    pub origin: Origin,
}

/// Parameter, nested object or reference.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Entry {
    /// Name as the front end spells it; empty where it gives none.
    pub name: Name,
    pub value: Value,
    /// Place of the entry, where it is not the object's entry of that name.
    pub origin: Option<Origin>,
}

impl Entry {
    /// Name in snake_case, however the front end spells it.
    pub fn key(&self) -> Cow<'_, str> {
        snake_case(&self.name)
    }
}

impl Object {
    /// Place of an entry of this object.
    pub fn origin_of(&self, entry: &Entry) -> Origin {
        entry.origin.clone().unwrap_or_else(|| self.origin.entry(&entry.name))
    }

    pub fn error(&self, message: impl Into<String>) -> Error {
        self.origin.error(message)
    }

    /// Error for a plugin that is not supported.
    pub fn unsupported(&self, supported: &[&str]) -> Error {
        let list = supported.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        self.error(format!("{} plugin `{}` is not supported; use one of {list}", self.kind.name(), self.plugin))
    }

    /// The object with one more entry.
    pub fn with(mut self, name: impl Into<Name>, value: Value) -> Self {
        self.entries.push(Entry { name: name.into(), value, origin: None });
        self
    }

    /// The object with an id.
    pub fn with_id(self, id: String) -> Self {
        Self { id: Some(id), ..self }
    }

    /// Sets the places of this object and of those nested in it.
    pub fn place(&mut self, origin: Origin) {
        self.origin = origin;
        for entry in &mut self.entries {
            if let Value::Object(object) = &mut entry.value {
                object.place(self.origin.object(".", &entry.name));
            }
        }
    }
}

/// Value of an entry.
#[derive(Debug, Clone)]
pub(in crate::scene) enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    Point([f64; 3]),
    Vector([f64; 3]),
    /// Numbers, as dictionaries give vectors of any length.
    Array(Vec<f64>),
    /// Color in linear sRGB.
    Rgb([f64; 3]),
    /// Color that the sRGB curve encodes.
    Srgb([f64; 3]),
    Spectrum(Spectrum),
    Transform(Transform),
    /// Transforms at points in time.
    Animation(Vec<(f64, Transform)>),
    /// Mesh in memory.
    Mesh(Arc<Mesh>),
    /// Grid of numbers in memory.
    Grid(Arc<Grid>),
    /// Image file in memory.
    Image(ImageFile),
    /// Object of that id.
    Reference(String),
    Object(Box<Object>),
    Fault(Box<Fault>),
}

/// Spectrum, as yet of no use as a material's or a light's.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::scene) enum Spectrum {
    /// One value for all wavelengths.
    Uniform(f64),
    /// Color in linear sRGB, as Mitsuba 0.6 takes three numbers.
    Rgb([f64; 3]),
    /// Wavelengths in nanometers with their values.
    Points(Vec<[f64; 2]>),
    /// Name of a file with wavelengths and values.
    File(String),
}

/// Image file in memory.
#[derive(Debug, Clone)]
pub(in crate::scene) struct ImageFile {
    /// Name, which no other image of the scene has.
    pub name: String,
    /// Content: an image of any format.
    pub bytes: Arc<[u8]>,
}

/// Entry that the front end could not read. It is an error where a plugin asks for it: real files hold faults in parameters that
/// no plugin has.
#[derive(Debug, Clone)]
pub(in crate::scene) struct Fault {
    /// Type of the parameter; `None` where the entry is no parameter at all, which is an error for every plugin.
    pub of: Option<Type>,
    pub message: String,
    /// Place of the fault, where it is not the entry's.
    pub origin: Option<Origin>,
}

impl Value {
    /// Value that could not be read.
    pub fn fault(of: Option<Type>, message: impl Into<String>) -> Self {
        Self::Fault(Box::new(Fault { of, message: message.into(), origin: None }))
    }

    /// Type of a parameter; `None` for what is no parameter of XML.
    pub fn type_of(&self) -> Option<Type> {
        match self {
            Self::Boolean(_) => Some(Type::Boolean),
            Self::Integer(_) => Some(Type::Integer),
            Self::Float(_) => Some(Type::Float),
            Self::Text(_) | Self::Image(_) => Some(Type::String),
            Self::Point(_) => Some(Type::Point),
            Self::Vector(_) | Self::Array(_) => Some(Type::Vector),
            Self::Rgb(_) => Some(Type::Rgb),
            Self::Srgb(_) => Some(Type::Srgb),
            Self::Spectrum(_) => Some(Type::Spectrum),
            Self::Transform(_) => Some(Type::Transform),
            Self::Animation(_) => Some(Type::Animation),
            Self::Object(object) if object.kind == Kind::Spectrum => Some(Type::Spectrum),
            Self::Fault(fault) => fault.of,
            Self::Mesh(_) | Self::Grid(_) | Self::Reference(_) | Self::Object(_) => None,
        }
    }
}
