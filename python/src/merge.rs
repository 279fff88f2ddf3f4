//! Pictures made from parts.

use std::path::PathBuf;

use lodestar::film;
use lodestar::film::merge::PartialPicture;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors::{raised, warn};
use crate::picture::Picture;
use crate::scene::path_of;
use crate::shared::detached;

/// Averages pictures of one scene with disjoint samples, every pixel by its sample counts.
///
/// Parts may differ in `sample_offset`, `seed`, length and device. All else must be alike, and no two parts may have a sample in
/// common. Parts rendered with `sample_offset` (0 for the first) give the same bits in any order.
///
/// Parameters
/// ----------
/// pictures : sequence of Picture or path of an EXR file
///     The parts, one or more.
#[pyfunction]
pub fn merge(py: Python<'_>, pictures: Vec<Bound<'_, PyAny>>) -> PyResult<Picture> {
    if pictures.is_empty() {
        return Err(PyValueError::new_err("merge needs one picture or more"));
    }
    let mut parts = Vec::new();
    for (at, part) in pictures.iter().enumerate() {
        parts.push(match part.cast::<Picture>() {
            Ok(picture) => {
                let Picture { picture, attributes, .. } = picture.get();
                let path = PathBuf::from(format!("picture {at}"));
                PartialPicture { path, picture: picture.clone(), attributes: attributes.clone() }
            }
            Err(_) => {
                let path = path_of(part)?;
                let (picture, attributes) = detached(py, || film::read_picture(&path))?.map_err(raised)?;
                PartialPicture { path, picture, attributes }
            }
        });
    }
    let (picture, attributes) = detached(py, || film::merge::merge(&parts))?.map_err(raised)?;
    let is_whole = |part: &&PartialPicture| part.picture.sums.is_empty();
    if let Some(part) = parts.iter().find(is_whole).filter(|_| !parts.iter().all(|part| is_whole(&part))) {
        let message = "it carries no sums, so the last bits depend on how the samples are divided; render it with sample_offset (0 for the first part)";
        warn(py, &[format!("{}: {message}", part.path.display())])?;
    }
    Ok(Picture::new(picture, attributes, None, None))
}
