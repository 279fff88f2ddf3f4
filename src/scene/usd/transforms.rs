//! Transforms of prims (`xformOpOrder`).

use glam::{DMat3, DMat4, DQuat, DVec3};
use openusd::sdf::Value;

use super::asset::Prim;
use super::values;
use crate::Result;

/// Transform of a prim, and whether it is relative to its parent.
pub(super) struct Local {
    pub matrix: DMat4,
    /// Whether it is a transform to the world: the prim resets the stack.
    pub resets: bool,
}

/// Transform of a prim.
pub(super) fn local(prim: &Prim) -> Result<Local> {
    let mut local = Local { matrix: DMat4::IDENTITY, resets: false };
    let Some(order) = prim.read("xformOpOrder", values::words)? else { return Ok(local) };
    for name in order {
        if name == "!resetXformStack!" {
            local = Local { matrix: DMat4::IDENTITY, resets: true };
            continue;
        }
        let (name, is_inverse) = match name.strip_prefix("!invert!") {
            Some(name) => (name, true),
            None => (&*name, false),
        };
        let Some(value) = prim.value(name)? else { continue };
        let kind = name.strip_prefix("xformOp:").unwrap_or(name).split(':').next().unwrap_or_default();
        let Some(matrix) = operation(kind, &value) else {
            prim.asset.warn_of(&prim.path, format!("its `{name}` is not known; it is ignored"));
            continue;
        };
        local.matrix *= if is_inverse { matrix.inverse() } else { matrix };
    }
    match local.matrix.is_finite() {
        true => Ok(local),
        false => Err(prim.asset.prim_error(&prim.path, "its transform is not finite, or has no inverse")),
    }
}

/// Matrix of one operation, whose columns are those of `DMat4`.
fn operation(kind: &str, value: &Value) -> Option<DMat4> {
    let vector = || values::triples(value).and_then(|list| list.first().copied()).map(DVec3::from_array);
    let along = |axis: DVec3| values::number(value).map(|number| axis * number);
    let about = |axis: DVec3| values::number(value).map(|angle| DMat4::from_axis_angle(axis, angle.to_radians()));
    let scaled = |axis: DVec3| values::number(value).map(|by| DMat4::from_scale(DVec3::ONE + axis * (by - 1.0)));
    match kind {
        "translate" => vector().map(DMat4::from_translation),
        "translateX" => along(DVec3::X).map(DMat4::from_translation),
        "translateY" => along(DVec3::Y).map(DMat4::from_translation),
        "translateZ" => along(DVec3::Z).map(DMat4::from_translation),
        "scale" => vector().map(DMat4::from_scale),
        "scaleX" => scaled(DVec3::X),
        "scaleY" => scaled(DVec3::Y),
        "scaleZ" => scaled(DVec3::Z),
        "rotateX" => about(DVec3::X),
        "rotateY" => about(DVec3::Y),
        "rotateZ" => about(DVec3::Z),
        "orient" => values::quaternions(value)?.first().map(|&q| DMat4::from_quat(quaternion(q))),
        "transform" => match value {
            Value::Matrix4d(matrix) => Some(affine(&DMat4::from_cols_array(&matrix.0))),
            _ => None,
        },
        _ => {
            // The axis that is named first turns first.
            let mut matrix = DMat4::IDENTITY;
            let angles = vector()?;
            for axis in kind.strip_prefix("rotate").filter(|axes| axes.len() == 3)?.chars() {
                let (axis, angle) = match axis {
                    'X' => (DVec3::X, angles.x),
                    'Y' => (DVec3::Y, angles.y),
                    'Z' => (DVec3::Z, angles.z),
                    _ => return None,
                };
                matrix = DMat4::from_axis_angle(axis, angle.to_radians()) * matrix;
            }
            Some(matrix)
        }
    }
}

/// The affine part of a matrix: points are divided by its last entry, which should be 1.
fn affine(matrix: &DMat4) -> DMat4 {
    let scale = Some(matrix.w_axis.w).filter(|last| *last != 0.0).map_or(1.0, f64::recip);
    let [x, y, z, w] = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(|axis| axis.truncate() * scale);
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), w.extend(1.0))
}

/// The rotation of a quaternion of any length but 0.
pub(super) fn quaternion(elements: [f64; 4]) -> DQuat {
    let quaternion = DQuat::from_array(elements);
    if quaternion.length_squared() > 0.0 && quaternion.is_finite() { quaternion.normalize() } else { DQuat::IDENTITY }
}

/// The matrix without its scale and shear, which do not change a camera.
pub(super) fn rigid(matrix: &DMat4) -> DMat4 {
    let linear = DMat3::from_mat4(*matrix);
    let z = linear.z_axis.normalize_or(DVec3::Z);
    let y = (linear.y_axis - linear.y_axis.dot(z) * z).normalize_or(z.any_orthonormal_vector());
    let columns = [y.cross(z), y, z].map(|axis| axis.extend(0.0));
    DMat4::from_cols(columns[0], columns[1], columns[2], matrix.w_axis)
}

/// Turns what looks along `+z`, as Mitsuba's cameras and lamps do, to USD's `-z`. `+y` stays up.
pub(super) fn turned(matrix: &DMat4) -> DMat4 {
    *matrix * DMat4::from_scale(DVec3::new(-1.0, 1.0, -1.0))
}
