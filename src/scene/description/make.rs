//! Objects and values in short form, for front ends that make them in code.

use std::path::Path;

use glam::DMat4;

use super::kinds::Kind;
use super::object::{Object, Value};
use super::origin::{Format, Name, Origin};
use super::transform::{Operation, Transform};

/// Object of that kind and plugin with its entries. Its place is set when the whole scene is made.
pub(in crate::scene) fn object<const N: usize>(
    kind: Kind,
    plugin: impl Into<Name>,
    entries: [(&'static str, Value); N],
) -> Object {
    let origin = Origin::whole(Path::new(""), Format::Foreign);
    let object = Object { kind, plugin: plugin.into(), id: None, entries: Vec::with_capacity(N), origin };
    entries.into_iter().fold(object, |object, (name, value)| object.with(name, value))
}

/// The BSDF on both sides of the surface.
pub(in crate::scene) fn two_sided(surface: Object) -> Object {
    object(Kind::Bsdf, "twosided", [("surface", nested(surface))])
}

/// Nested object.
pub(in crate::scene) fn nested(object: Object) -> Value {
    Value::Object(Box::new(object))
}

/// Number.
pub(in crate::scene) fn number(value: f32) -> Value {
    Value::Float(f64::from(value))
}

/// Color in linear sRGB.
pub(in crate::scene) fn color(rgb: [f32; 3]) -> Value {
    Value::Rgb(rgb.map(f64::from))
}

/// Transform by a matrix.
pub(in crate::scene) fn matrix(matrix: &DMat4) -> Value {
    Value::Transform(transform(matrix))
}

fn transform(matrix: &DMat4) -> Transform {
    Transform { operations: vec![Operation::Matrix(matrix.transpose().to_cols_array())] }
}

/// Transform by matrices at points in time.
pub(in crate::scene) fn animation(keys: &[(f64, DMat4)]) -> Value {
    Value::Animation(keys.iter().map(|(time, matrix)| (*time, transform(matrix))).collect())
}
