//! Arrays of numpy, from and to plain numbers.

use numpy::{Element, PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
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

/// Shape and values of anything that numpy takes for an array of numbers.
pub fn numbers(value: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("array", (value, numpy.getattr("float64")?))?;
    let array = numpy.call_method1("ascontiguousarray", (&array,)).and_then(|contiguous| {
        // `ascontiguousarray` gives a single number one axis.
        contiguous.call_method1("reshape", (array.getattr("shape")?,))
    })?;
    let array: PyReadonlyArrayDyn<'_, f64> = array.extract()?;
    Ok((array.shape().to_vec(), array.as_slice()?.to_vec()))
}
