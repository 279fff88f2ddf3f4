//! Arrays of numpy, from and to plain numbers.

use numpy::{Element, PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// An array of that shape with a copy of `values`, the last axis running fastest. It cannot be written to, because no change would
/// reach the object that it belongs to.
pub fn frozen<T: Element + Copy, const N: usize>(
    py: Python<'_>,
    values: &[T],
    shape: [usize; N],
) -> PyResult<Py<PyAny>> {
    let array = PyArray1::from_slice(py, values).reshape(shape.to_vec())?;
    array.call_method1("setflags", (false,))?;
    Ok(array.into_any().unbind())
}

/// Largest whole number up to which every whole number is a number with a fraction, too.
const MAX_EXACT: f64 = (1u64 << 53) as f64;

/// Shape and values of an array of numbers, or of anything that numpy makes one of. Booleans, complex numbers, dates, texts and objects
/// are no numbers, and a whole number must be exact.
pub fn numbers(value: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let numpy = value.py().import("numpy")?;
    let given = numpy.call_method1("asarray", (value,))?;
    let kind: String = given.getattr("dtype")?.getattr("kind")?.extract()?;
    let is_empty = given.getattr("size")?.extract::<usize>()? == 0;
    let refused_kind = match &kind[..] {
        "i" | "u" | "f" => None,
        // An empty list of lists of other kinds has no value of a wrong kind.
        _ if is_empty => None,
        "b" => Some("booleans"),
        "c" => Some("complex numbers"),
        "m" | "M" => Some("dates or times"),
        "U" | "S" | "T" => Some("texts"),
        _ => Some("objects"),
    };
    if let Some(kind) = refused_kind {
        return Err(PyTypeError::new_err(format!("its values are {kind}, not numbers; convert them first")));
    }
    let array = numpy.call_method1("array", (&given, numpy.getattr("float64")?))?;
    let array = numpy.call_method1("ascontiguousarray", (&array,)).and_then(|contiguous| {
        // `ascontiguousarray` gives a single number one axis.
        contiguous.call_method1("reshape", (array.getattr("shape")?,))
    })?;
    let array: PyReadonlyArrayDyn<'_, f64> = array.extract()?;
    let values = array.as_slice()?;
    if kind != "f" && values.iter().any(|value| value.abs() >= MAX_EXACT) {
        return Err(PyValueError::new_err("it has whole numbers above 2^53, which would be rounded"));
    }
    Ok((array.shape().to_vec(), values.to_vec()))
}
