//! Scenes as Python's dictionaries.

use lodestar::scene::{Array, Dictionary, Operation, Transform, Value};
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyMapping, PyString};

use crate::arrays::numbers;
use crate::errors::refused;
use crate::transform::ScalarTransform4f;

/// Deepest nesting of dictionaries. One that contains itself is deeper.
const MAX_DEPTH: usize = 100;
/// Name of the whole dictionary in messages.
const ROOT: &str = "scene";

/// The library's form of a scene's dictionary.
pub fn scene_dictionary(value: &Bound<'_, PyAny>) -> PyResult<Dictionary> {
    dictionary(value, ROOT, 0)
}

fn dictionary(value: &Bound<'_, PyAny>, path: &str, depth: usize) -> PyResult<Dictionary> {
    if depth > MAX_DEPTH {
        return Err(refused(format!("{ROOT}: entries are nested more than {MAX_DEPTH} deep")));
    }
    let mut entries = Vec::new();
    for item in value.cast::<PyMapping>()?.items()? {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let Ok(key) = key.extract::<String>() else {
            return Err(refused(format!("{path}: the key {} is no string", key.repr()?)));
        };
        let path = format!("{path}.{key}");
        entries.push((key, entry(&value, &path, depth)?));
    }
    Ok(Dictionary { entries })
}

fn entry(value: &Bound<'_, PyAny>, path: &str, depth: usize) -> PyResult<Value> {
    if let Ok(transform) = value.cast::<ScalarTransform4f>() {
        return Ok(Value::Transform(transform.get().transform().clone()));
    }
    if value.is_instance_of::<PyDict>() || value.cast::<PyMapping>().is_ok() {
        return Ok(Value::Object(dictionary(value, path, depth + 1)?));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::Text(text.extract()?));
    }
    let of_other = |error: PyErr| match error.is_instance_of::<PyException>(value.py()) {
        true => refused(format!("{path}: {} is no value of a parameter ({error})", of_type(value))),
        false => error,
    };
    other(value).map_err(of_other)
}

/// A number, an array, a transform of Mitsuba, or a path.
fn other(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if value.is_none() {
        return Err(refused("give a number, a string, an array or a dictionary"));
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(Value::Integer(whole));
    }
    if value.hasattr("__fspath__")? {
        return Ok(Value::Text(value.call_method0("__fspath__")?.extract()?));
    }
    if value.hasattr("matrix")? {
        let (shape, rows) = numbers(&value.getattr("matrix")?)?;
        let rows = <[f64; 16]>::try_from(rows).ok().filter(|_| shape == [4, 4]);
        let rows = rows.ok_or_else(|| refused(format!("its `matrix` has the shape {shape:?}, not 4 x 4")))?;
        return Ok(Value::Transform(Transform { operations: vec![Operation::Matrix(rows)] }));
    }
    if is_numpy_bool(value)? {
        return Ok(Value::Boolean(value.is_truthy()?));
    }
    let (shape, values) = numbers(value)?;
    match (&shape[..], &values[..]) {
        ([], &[number]) => Ok(Value::Number(number)),
        _ => Ok(Value::Array(Array { shape, values })),
    }
}

fn is_numpy_bool(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    value.is_instance(&value.py().import("numpy")?.getattr("bool_")?)
}

fn of_type(value: &Bound<'_, PyAny>) -> String {
    let name = value.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
    format!("a value of the type `{name}`")
}
