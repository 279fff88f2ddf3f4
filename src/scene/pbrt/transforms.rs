//! Transforms of pbrt. They are the same numbers as in Mitsuba; only a camera's `+x` points to the right, not to the left.

use glam::{DMat4, DVec3, DVec4};

use super::tokens::Place;
use crate::Result;

/// Current transform, from an object's space to the world, with its inverse. The inverse of what a directive gives is exact
/// where that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Current {
    pub matrix: DMat4,
    pub inverse: DMat4,
}

impl Current {
    pub const IDENTITY: Self = Self { matrix: DMat4::IDENTITY, inverse: DMat4::IDENTITY };

    /// This transform after another, which is applied to points first.
    pub fn after(&self, first: &Self) -> Self {
        Self { matrix: self.matrix * first.matrix, inverse: first.inverse * self.inverse }
    }

    /// The inverse transform.
    pub fn inverted(&self) -> Self {
        Self { matrix: self.inverse, inverse: self.matrix }
    }

    /// Translation by a vector.
    pub fn translation(by: [f64; 3]) -> Self {
        let by = DVec3::from(by);
        Self { matrix: DMat4::from_translation(by), inverse: DMat4::from_translation(-by) }
    }

    /// Scale along the axes.
    pub fn scale(by: [f64; 3], place: &Place) -> Result<Self> {
        let by = DVec3::from(by);
        let inverse = by.recip();
        match inverse.is_finite() {
            true => Ok(Self { matrix: DMat4::from_scale(by), inverse: DMat4::from_scale(inverse) }),
            false => Err(place.error("Scale: a factor of 0 flattens everything; use a small number")),
        }
    }

    /// Rotation by an angle in degrees about an axis.
    pub fn rotation([degrees, x, y, z]: [f64; 4], place: &Place) -> Result<Self> {
        let axis = DVec3::new(x, y, z).try_normalize().ok_or_else(|| place.error("Rotate: the axis has length 0"))?;
        let matrix = DMat4::from_axis_angle(axis, degrees.to_radians());
        Ok(Self { matrix, inverse: matrix.transpose() })
    }

    /// Transform to the space of a camera that looks from one point at another.
    pub fn look_at(numbers: [f64; 9], place: &Place) -> Result<Self> {
        let [ex, ey, ez, lx, ly, lz, ux, uy, uz] = numbers;
        let (eye, look, up) = (DVec3::new(ex, ey, ez), DVec3::new(lx, ly, lz), DVec3::new(ux, uy, uz));
        let forward =
            (look - eye).try_normalize().ok_or_else(|| place.error("LookAt: the camera looks at its own place"))?;
        let right = up.cross(forward).try_normalize();
        let right = right.ok_or_else(|| place.error("LookAt: `up` is zero or parallel to the viewing direction"))?;
        let up = forward.cross(right);
        let world_from_camera =
            DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0));
        Ok(Self { matrix: world_from_camera.inverse(), inverse: world_from_camera })
    }

    /// Transform by a matrix whose numbers stand column by column.
    pub fn of_columns(numbers: [f64; 16], place: &Place) -> Result<Self> {
        let matrix = DMat4::from_cols_array(&numbers);
        let last = matrix.row(3);
        if last.w == 0.0 || last.truncate() != DVec3::ZERO {
            return Err(place.error("every fourth number of a matrix must be 0, and the last one must not be 0"));
        }
        let matrix = if last == DVec4::W { matrix } else { matrix * (1.0 / last.w) };
        let mut inverse = matrix.inverse();
        match inverse.is_finite() && matrix.determinant() != 0.0 {
            true => {
                // Rounding must not make it projective.
                (inverse.x_axis.w, inverse.y_axis.w, inverse.z_axis.w, inverse.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
                Ok(Self { matrix, inverse })
            }
            false => Err(place.error("the matrix has no inverse: it flattens everything")),
        }
    }

    /// Whether the transform is within the range of single precision.
    pub fn is_finite(&self) -> bool {
        [self.matrix, self.inverse].iter().all(|matrix| matrix.to_cols_array().iter().all(|&x| (x as f32).is_finite()))
    }
}

/// Whether the transform turns right-handed frames into left-handed ones.
pub(super) fn is_mirrored(matrix: &DMat4) -> bool {
    matrix.determinant() < 0.0
}

/// Linear part of a similarity without its scale, and the scale; `None` where the transform is no similarity.
pub(super) fn rigid(matrix: &DMat4) -> Option<(DMat4, f64)> {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
    let scale = axes[0].length();
    let is_even = axes.iter().all(|axis| (axis.length() - scale).abs() <= 1.0e-3 * scale);
    let dots = [axes[0].dot(axes[1]), axes[1].dot(axes[2]), axes[2].dot(axes[0])];
    let is_square = dots.iter().all(|dot| dot.abs() <= 1.0e-3 * scale * scale);
    if !(is_even && is_square && scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let [x, y, z] = axes.map(|axis| (axis / axis.length()).extend(0.0));
    Some((DMat4::from_cols(x, y, z, matrix.w_axis), scale))
}
