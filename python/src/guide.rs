//! Guides: what a render has learned about where light comes from.

use std::sync::Arc;

use lodestar::renderer::learned_guide::LearnedGuide;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::arrays::{frozen, numbers};
use crate::errors::refused;
use crate::renderer::Shared;

/// What a render has learned: radiance by cell and direction, at the moment when it was asked for.
///
/// With emitter sampling (`nee`, which is on by default), a guide holds the light that emitter sampling does not find. `nee=False`
/// shows all light.
#[pyclass(frozen, module = "lodestar")]
pub struct Guide {
    guide: LearnedGuide,
    of: Arc<Shared>,
    arrays: [PyOnceLock<Py<PyAny>>; 3],
}

impl Guide {
    /// The guide of a render.
    pub fn new(guide: LearnedGuide, of: Arc<Shared>) -> Self {
        Self { guide, of, arrays: [const { PyOnceLock::new() }; 3] }
    }

    /// The guide itself.
    pub fn learned(&self) -> &LearnedGuide {
        &self.guide
    }
}

#[pymethods]
impl Guide {
    /// Lower and upper corner of every cell, (cells, 2, 3) float32, world space.
    #[getter]
    fn cells(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let make = || {
            let corners: Vec<f32> = self.guide.cells().iter().flatten().flat_map(|corner| corner.to_array()).collect();
            frozen(py, &corners, [corners.len() / 6, 2, 3])
        };
        self.arrays[0].get_or_try_init(py, make).map(|array| array.clone_ref(py))
    }

    /// Unit direction of the center of every bin, (bins, 3) float64, world space, away from the surface. All bins have the same
    /// solid angle: 4 pi / bins.
    #[getter]
    fn directions(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let make = || {
            let values: Vec<f64> = self.guide.directions().iter().flat_map(|unit| unit.to_array()).collect();
            frozen(py, &values, [values.len() / 3, 3])
        };
        self.arrays[1].get_or_try_init(py, make).map(|array| array.clone_ref(py))
    }

    /// Learned radiance, (cells, bins) float32: the mean over RGB that arrives from each direction, W/(m^2 sr).
    #[getter]
    fn radiance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let bins = self.guide.side().pow(2) as usize;
        let make = || frozen(py, self.guide.radiance(), [self.guide.radiance().len() / bins, bins]);
        self.arrays[2].get_or_try_init(py, make).map(|array| array.clone_ref(py))
    }

    /// Bins along each side of the square map of directions.
    #[getter]
    fn side(&self) -> u32 {
        self.guide.side()
    }

    /// Learned radiance at the surface that the center of a pixel shows, (side, side) float32, in the order of `directions`.
    ///
    /// Parameters
    /// ----------
    /// pixel : (x, y)
    ///     Column and row, from the top left of the whole film. The first question about a pixel renders one small sample there.
    fn radiance_at(&self, py: Python<'_>, pixel: (u32, u32)) -> PyResult<Py<PyAny>> {
        let point = self.of.point(py, pixel)?;
        self.map(py, point.position)
    }

    /// Learned radiance at a point of the scene, (side, side) float32, in the order of `directions`.
    fn radiance_at_point(&self, py: Python<'_>, position: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let (shape, values) = numbers(position)?;
        match (&shape[..], &values[..]) {
            ([3], &[x, y, z]) if values.iter().all(|value| value.is_finite()) => {
                self.map(py, glam::DVec3::new(x, y, z).as_vec3())
            }
            _ => Err(refused("a position has three finite numbers")),
        }
    }

    /// Position and normal, world space, of the surface that the center of a pixel (x, y) shows. The normal is on the camera's
    /// side.
    fn surface_at(&self, py: Python<'_>, pixel: (u32, u32)) -> PyResult<([f32; 3], [f32; 3])> {
        let point = self.of.point(py, pixel)?;
        Ok((point.position.to_array(), point.normal.to_array()))
    }

    fn __repr__(&self) -> String {
        let bins = self.guide.side().pow(2) as usize;
        format!("<lodestar.Guide: {} cells, {bins} directions>", self.guide.radiance().len() / bins)
    }
}

impl Guide {
    fn map(&self, py: Python<'_>, position: glam::Vec3) -> PyResult<Py<PyAny>> {
        let side = self.guide.side() as usize;
        frozen(py, self.guide.radiance_at(position), [side, side])
    }
}
