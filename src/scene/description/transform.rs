//! Transforms as chains of operations.

use std::path::Path;

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::origin::{Format, Origin};
use crate::Result;

/// A transform as a chain of operations, as a scene file writes it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Transform {
    /// The operations; the first is applied first.
    pub operations: Vec<Operation>,
}

/// One operation of a transform.
#[derive(Debug, Clone, PartialEq)]
pub enum Operation {
    /// A translation by a vector.
    Translate([f64; 3]),
    /// A scale by a factor along each axis.
    Scale([f64; 3]),
    /// A rotation about an axis, by an angle in degrees.
    Rotate {
        /// Axis. Its length should be 1: as in Mitsuba 3, another length scales, too.
        axis: [f64; 3],
        /// Angle in degrees, counterclockwise where the axis points to the viewer.
        degrees: f64,
    },
    /// A camera's place: `+z` looks from the origin to the target, `+x` points to the left of the picture.
    LookAt {
        /// Position of the camera.
        origin: [f64; 3],
        /// Point that the camera looks at.
        target: [f64; 3],
        /// Direction that points up in the picture.
        up: [f64; 3],
    },
    /// A matrix of four rows. The last row is 0 0 0 1.
    Matrix([f64; 16]),
}

impl Transform {
    /// Product of the operations, to the last bit as the reader of scenes computes it. The columns are those of `DMat4`.
    ///
    /// # Errors
    /// Where a number is not finite, an axis is zero, or a camera looks along its `up`.
    pub fn matrix(&self) -> Result<[f64; 16]> {
        let origin = Origin::whole(Path::new("transform"), Format::Dictionary);
        self.product(origin.format).map(|matrix| matrix.to_cols_array()).map_err(|message| origin.error(message))
    }

    /// Product of the operations. In f64, so that long chains keep their accuracy. The error is in the words of the format.
    pub(in crate::scene) fn product(&self, format: Format) -> Result<DMat4, String> {
        self.operations.iter().try_fold(DMat4::IDENTITY, |below, operation| Ok(operation.matrix(format)? * below))
    }
}

impl Operation {
    /// Matrix of the operation. The error is in the words of the format.
    pub(in crate::scene) fn matrix(&self, format: Format) -> Result<DMat4, String> {
        self.numbers().into_iter().try_for_each(|number| finite(*number).map(drop))?;
        match *self {
            Self::Translate(by) => Ok(DMat4::from_translation(by.into())),
            Self::Scale(by) => Ok(DMat4::from_scale(by.into())),
            Self::Rotate { axis, degrees } => rotation(axis.into(), degrees, format),
            Self::LookAt { origin, target, up } => look_at(origin.into(), target.into(), up.into(), format),
            Self::Matrix(rows) => {
                let matrix = DMat4::from_cols_array(&rows).transpose();
                match matrix.row(3) == DVec4::W {
                    true => Ok(matrix),
                    false => Err(format!("the last row of a {} must be 0 0 0 1", format.word("matrix"))),
                }
            }
        }
    }

    fn numbers(&self) -> Vec<&f64> {
        match self {
            Self::Translate(by) | Self::Scale(by) => by.iter().collect(),
            Self::Rotate { axis, degrees } => axis.iter().chain([degrees]).collect(),
            Self::LookAt { origin, target, up } => origin.iter().chain(target).chain(up).collect(),
            Self::Matrix(rows) => rows.iter().collect(),
        }
    }

    /// Rotation as Mitsuba 0.6 makes it, which normalizes the axis. A matrix stands for it where Mitsuba 3 would scale.
    pub(in crate::scene) fn old_rotation(axis: [f64; 3], degrees: f64) -> Self {
        match DVec3::from(axis).try_normalize() {
            Some(unit) if !is_unit(axis) => {
                let rows = DMat4::from_axis_angle(unit, degrees.to_radians()).transpose().to_cols_array();
                Self::Matrix(rows)
            }
            _ => Self::Rotate { axis, degrees },
        }
    }
}

/// Number that the device, which uses f32, can hold.
pub(in crate::scene) fn finite(value: f64) -> Result<f64, String> {
    match (value as f32).is_finite() {
        true => Ok(value),
        false => Err(format!("`{value:?}` is not a finite number")),
    }
}

/// Whether an axis has length 1 to the precision of printed scene files.
fn is_unit(axis: [f64; 3]) -> bool {
    (DVec3::from(axis).length() - 1.0).abs() < 1e-5
}

/// Length of an axis about which versions of Mitsuba rotate differently: one that is neither 1 nor 0.
pub(in crate::scene) fn odd_length(axis: [f64; 3]) -> Option<f64> {
    (!is_unit(axis) && axis != [0.0; 3]).then(|| DVec3::from(axis).length())
}

/// Rotation as in Mitsuba 3: an axis of another length than 1 makes a matrix that scales and shears, too.
fn rotation(given: DVec3, degrees: f64, format: Format) -> Result<DMat4, String> {
    let angle = degrees.to_radians();
    let axis =
        given.try_normalize().ok_or_else(|| format!("{} needs an axis: x, y or z is not 0", format.word("rotate")))?;
    if is_unit(given.to_array()) {
        return Ok(DMat4::from_axis_angle(axis, angle));
    }
    let (sine, cosine) = angle.sin_cos();
    let column = |unit: DVec3| given * given.dot(unit) * (1.0 - cosine) + unit * cosine + given.cross(unit) * sine;
    Ok(DMat4::from_mat3(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))))
}

/// Transform from camera to world: `+z` looks from origin to target, `+x` points to the left of the picture.
fn look_at(origin: DVec3, target: DVec3, up: DVec3, format: Format) -> Result<DMat4, String> {
    let word = || format.word("lookat");
    let forward = (target - origin).try_normalize().ok_or_else(|| format!("{}: origin equals target", word()))?;
    let left = (up.cross(forward))
        .try_normalize()
        .ok_or_else(|| format!("{}: `up` is zero or parallel to the viewing direction", word()))?;
    let up = forward.cross(left);
    Ok(DMat4::from_cols(left.extend(0.0), up.extend(0.0), forward.extend(0.0), origin.extend(1.0)))
}
