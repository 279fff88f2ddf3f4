//! Transforms, as Mitsuba's scenes in code have them.

use lodestar::scene::{Operation, Transform};
use pyo3::prelude::*;

use crate::arrays::{frozen, numbers};
use crate::errors::{raised, refused};

/// A transform of a shape, a camera or a texture, as a chain of operations.
///
/// Methods are called in the order in which Mitsuba's are: `ScalarTransform4f().translate(a).scale(b)` scales first. `first @ second`
/// applies `second` first. A scene has the same bits with a transform and with the same operations in its XML.
///
/// Parameters
/// ----------
/// matrix : array of shape (4, 4), optional
///     Matrix that multiplies column vectors. Its last row is 0 0 0 1. Default: the identity.
#[pyclass(frozen, module = "lodestar")]
pub struct ScalarTransform4f(Transform);

impl ScalarTransform4f {
    /// The transform itself.
    pub fn transform(&self) -> &Transform {
        &self.0
    }

    /// This transform after `operation`.
    fn after(&self, operation: Operation) -> PyResult<Self> {
        let operations = std::iter::once(operation).chain(self.0.operations.iter().cloned()).collect();
        Self(Transform { operations }).checked()
    }

    fn checked(self) -> PyResult<Self> {
        self.0.matrix().map_err(raised)?;
        Ok(self)
    }
}

#[pymethods]
impl ScalarTransform4f {
    #[new]
    #[pyo3(signature = (matrix = None))]
    fn new(matrix: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(matrix) = matrix else { return Ok(Self(Transform::default())) };
        let (shape, rows) = numbers(matrix)?;
        let rows = <[f64; 16]>::try_from(rows).ok().filter(|_| shape == [4, 4]);
        let rows = rows.ok_or_else(|| refused(format!("a transform's matrix has 4 x 4 numbers, not {shape:?}")))?;
        Self(Transform { operations: vec![Operation::Matrix(rows)] }).checked()
    }

    /// This transform after a translation by `v`, three numbers.
    fn translate(&self, v: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.after(Operation::Translate(three("v", v)?))
    }

    /// This transform after a scale by `v`, one number or three.
    fn scale(&self, v: &Bound<'_, PyAny>) -> PyResult<Self> {
        let factors = match &numbers(v)?.1[..] {
            &[one] => [one; 3],
            _ => three("v", v)?,
        };
        self.after(Operation::Scale(factors))
    }

    /// This transform after a rotation about `axis`, three numbers of length 1, by `angle` degrees.
    fn rotate(&self, axis: &Bound<'_, PyAny>, angle: f64) -> PyResult<Self> {
        self.after(Operation::Rotate { axis: three("axis", axis)?, degrees: angle })
    }

    /// This transform after a camera's at `origin` that looks at `target`. `up` points up in the picture.
    fn look_at(&self, origin: &Bound<'_, PyAny>, target: &Bound<'_, PyAny>, up: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (origin, target, up) = (three("origin", origin)?, three("target", target)?, three("up", up)?);
        self.after(Operation::LookAt { origin, target, up })
    }

    /// The matrix, shape (4, 4), float64. It multiplies column vectors.
    #[getter]
    fn matrix(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let columns = self.0.matrix().map_err(raised)?;
        let rows: [f64; 16] = std::array::from_fn(|at| columns[at % 4 * 4 + at / 4]);
        frozen(py, &rows, [4, 4])
    }

    fn __matmul__(&self, other: &Self) -> PyResult<Self> {
        let operations = other.0.operations.iter().chain(&self.0.operations).cloned().collect();
        Self(Transform { operations }).checked()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("ScalarTransform4f({})", self.matrix(py)?.bind(py).call_method0("tolist")?.repr()?))
    }
}

fn three(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let (shape, values) = numbers(value)?;
    values.try_into().ok().filter(|_| shape == [3]).ok_or_else(|| refused(format!("`{name}` must have three numbers")))
}
