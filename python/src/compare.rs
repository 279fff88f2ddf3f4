//! Errors of pictures.

use lodestar::image::comparison::Comparison;
use lodestar::image::{Image, exr};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::numbers;
use crate::errors::raised;
use crate::picture::Picture;
use crate::scene::path_of;
use crate::shared::{detached, from_json};

/// Measures the error of a picture against a reference of the same size.
///
/// Parameters
/// ----------
/// picture, reference : Picture, path of an EXR file, or array of shape (height, width, 3)
///     Linear radiance.
///
/// Returns
/// -------
/// dict
///     `mae_ldr` (mean absolute difference under the paper's tone curve), `mae`, `mse`, `relmse` (relative mean squared
///     difference), `relmse_trim` (the same without the worst 0.1 % of the pixels), `smape` (symmetric mean absolute difference:
///     over the sum of both), `flip` (difference that a viewer sees, from 0 to 1) and `mean_ratio` (mean of the picture over mean
///     of the reference), as `lodestar compare --json` prints them.
#[pyfunction]
pub fn compare(picture: &Bound<'_, PyAny>, reference: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
    let py = picture.py();
    let (picture, reference) = (image(picture)?, image(reference)?);
    let measured = detached(py, || Comparison::new(&picture, &reference))?.map_err(raised)?;
    let measured = from_json(py, &measured.0)?;
    // JSON has no number that is not finite: the mean ratio to a black reference.
    if measured.bind(py).get_item("mean_ratio")?.is_none() {
        measured.bind(py).set_item("mean_ratio", f64::NAN)?;
    }
    Ok(measured)
}

fn image(value: &Bound<'_, PyAny>) -> PyResult<Image> {
    if let Ok(picture) = value.cast::<Picture>() {
        return Ok(picture.get().picture().image());
    }
    if value.hasattr("__array__")? {
        let (shape, values) = numbers(value)?;
        return match shape[..] {
            [height, width, 3] => {
                let (width, height) = (width as u32, height as u32);
                let pixels = values.chunks_exact(3).map(|rgb| [rgb[0] as f32, rgb[1] as f32, rgb[2] as f32]);
                Ok(Image { width, height, pixels: pixels.collect() })
            }
            _ => Err(PyValueError::new_err(format!("a picture has the shape (height, width, 3), not {shape:?}"))),
        };
    }
    let path = path_of(value)?;
    detached(value.py(), || exr::read_rgb(&path))?.map_err(raised)
}
