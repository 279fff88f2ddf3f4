//! Short forms for the entries of a description.

use glam::DMat4;

use crate::scene::mitsuba::dictionary::{Array, Dictionary, Operation, Transform, Value};

/// Object of a plugin with its entries.
pub(super) fn object<const N: usize>(plugin: &str, entries: [(&str, Value); N]) -> Dictionary {
    let mut result = Dictionary { entries: vec![("type".to_owned(), text(plugin))] };
    entries.into_iter().for_each(|(key, value)| set(&mut result, key, value));
    result
}

/// Adds an entry.
pub(super) fn set(dictionary: &mut Dictionary, key: &str, value: Value) {
    dictionary.entries.push((key.to_owned(), value));
}

/// Text, or the name of a file.
pub(super) fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

/// Linear color.
pub(super) fn rgb(color: [f32; 3]) -> Value {
    let array = Array { shape: vec![3], values: color.map(f64::from).to_vec() };
    Value::Object(object("rgb", [("value", Value::Array(array))]))
}

/// Number.
pub(super) fn number(value: f32) -> Value {
    Value::Number(f64::from(value))
}

/// Transform by a matrix.
pub(super) fn matrix(matrix: DMat4) -> Value {
    let rows = matrix.transpose().to_cols_array();
    Value::Transform(Transform { operations: vec![Operation::Matrix(rows)] })
}

/// Reference to an object by its key.
pub(super) fn reference(id: &str) -> Value {
    Value::Object(object("ref", [("id", text(id))]))
}
