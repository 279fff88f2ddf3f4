//! Values of dictionaries in short form.

use glam::DMat4;

use crate::scene::{Array, Dictionary, Operation, Transform, Value};

/// Object of that type with its entries.
pub(super) fn object<const N: usize>(kind: &str, entries: [(&str, Value); N]) -> Dictionary {
    let kind = ("type".to_owned(), Value::Text(kind.to_owned()));
    let entries = entries.into_iter().map(|(key, value)| (key.to_owned(), value));
    Dictionary { entries: std::iter::once(kind).chain(entries).collect() }
}

/// Object that refers to the object with that id.
pub(super) fn reference(id: &str) -> Dictionary {
    object("ref", [("id", Value::Text(id.to_owned()))])
}

/// The dictionary with one more entry.
pub(super) fn with(mut dictionary: Dictionary, key: &str, value: Value) -> Dictionary {
    dictionary.entries.push((key.to_owned(), value));
    dictionary
}

/// Number.
pub(super) fn number(value: f32) -> Value {
    Value::Number(f64::from(value))
}

/// Color in linear sRGB.
pub(super) fn color(rgb: [f32; 3]) -> Value {
    let values = rgb.map(f64::from).into();
    Value::Object(object("rgb", [("value", Value::Array(Array { shape: vec![3], values }))]))
}

/// Transform by a matrix.
pub(super) fn matrix(matrix: &DMat4) -> Value {
    let rows = matrix.transpose().to_cols_array();
    Value::Transform(Transform { operations: vec![Operation::Matrix(rows)] })
}
