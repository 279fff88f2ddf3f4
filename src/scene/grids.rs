//! Grids of numbers, as volumes of media have them.

use std::sync::Arc;

use glam::{DVec3, UVec3};

use super::texel_pages::PAGE_WORDS;

/// Largest magnitude of a negative number that counts as 0, as a share of the largest number.
const ROUNDING: f32 = 1.0e-6;

/// Grid of numbers or colors over a box. No number is negative.
#[derive(Debug)]
pub(super) struct Grid {
    /// Voxels along each axis.
    pub size: UVec3,
    /// Whether each voxel has three numbers.
    pub has_colors: bool,
    /// Numbers, x fastest, then y, then z.
    pub values: Arc<Vec<f32>>,
    /// Lower and upper corner of the box that its file names.
    pub corners: [DVec3; 2],
}

impl Grid {
    /// Grid of these values over the unit cube. The message of an error goes on after the name of the grid.
    pub fn new(size: UVec3, has_colors: bool, mut values: Vec<f32>) -> Result<Self, String> {
        let count = Self::count(size, if has_colors { 3 } else { 1 })?;
        if values.len() as u64 != count {
            let [x, y, z] = size.to_array();
            return Err(format!("has {} numbers, but {x} x {y} x {z} voxels need {count}", values.len()));
        }
        // Exporters interpolate, and round below 0.
        let largest = values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f32::max);
        values.iter_mut().filter(|value| (-ROUNDING * largest..0.0).contains(*value)).for_each(|value| *value = 0.0);
        match values.iter().find(|value| !value.is_finite() || **value < 0.0) {
            Some(value) if value.is_finite() => Err(format!("has the negative value {value}")),
            Some(value) => Err(format!("has a value that is no finite number: {value}")),
            None => Ok(Self { size, has_colors, values: Arc::new(values), corners: [DVec3::ZERO, DVec3::ONE] }),
        }
    }

    /// Number of values of a grid, if a device can hold it.
    pub fn count(size: UVec3, channels: u32) -> Result<u64, String> {
        let [x, y, z] = size.to_array();
        if size.min_element() == 0 {
            return Err(format!("has {x} x {y} x {z} voxels, which are none"));
        }
        let count = size.to_array().into_iter().map(u64::from).try_fold(u64::from(channels), u64::checked_mul);
        count.filter(|&count| count <= PAGE_WORDS).ok_or_else(|| {
            format!("has {x} x {y} x {z} voxels; at most {PAGE_WORDS} numbers are supported, so give it fewer voxels")
        })
    }
}
