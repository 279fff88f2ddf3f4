//! Reader of `<transform>`. Each operation is applied after the operations above it.

use glam::{DMat3, DMat4, DVec3, DVec4, Mat3};

use super::element::Element;
use super::numbers;
use crate::Result;

/// Product of a `<transform>`'s operations. In f64, so that long chains keep their accuracy.
pub(super) fn parse(element: &Element) -> Result<DMat4> {
    element.children.iter().try_fold(DMat4::IDENTITY, |below, operation| Ok(parse_operation(operation)? * below))
}

fn parse_operation(operation: &Element) -> Result<DMat4> {
    match operation.tag.as_str() {
        "translate" => Ok(DMat4::from_translation(numbers::xyz(operation, 0.0)?.into())),
        "scale" => parse_scale(operation),
        "rotate" => parse_rotate(operation),
        "lookat" => parse_lookat(operation),
        "matrix" => parse_matrix(operation),
        tag => Err(operation.error(format!("<{tag}> is not a transform operation"))),
    }
}

fn parse_scale(element: &Element) -> Result<DMat4> {
    let factors = match element.attribute("value") {
        Some(value) => numbers::one_or_three(element, value)?,
        None => numbers::xyz(element, 1.0)?,
    };
    Ok(DMat4::from_scale(factors.into()))
}

/// Reads a rotation. Mitsuba 0.6 normalizes the axis. Mitsuba 3 does not: an axis of another length makes a matrix that
/// scales and shears, too. Each file gets the matrix of its own version.
pub(super) fn parse_rotate(element: &Element) -> Result<DMat4> {
    let given = DVec3::from(numbers::xyz(element, 0.0)?);
    let angle = numbers::one(element, element.required("angle")?)?.to_radians();
    let axis = given.try_normalize().ok_or_else(|| element.error("<rotate> needs an axis: x, y or z is not 0"))?;
    if element.is_old || is_unit(given) {
        return Ok(DMat4::from_axis_angle(axis, angle));
    }
    let (sine, cosine) = angle.sin_cos();
    let column = |unit: DVec3| given * given.dot(unit) * (1.0 - cosine) + unit * cosine + given.cross(unit) * sine;
    Ok(DMat4::from_mat3(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))))
}

/// Whether an axis has length 1 to the precision of printed scene files.
fn is_unit(axis: DVec3) -> bool {
    (axis.length() - 1.0).abs() < 1e-5
}

/// Warning about an operation that versions of Mitsuba understand differently: a rotation about an axis whose length is
/// not 1.
pub(super) fn warning(operation: &Element) -> Result<Option<String>> {
    if operation.tag != "rotate" {
        return Ok(None);
    }
    let axis = DVec3::from(numbers::xyz(operation, 0.0)?);
    if is_unit(axis) || axis == DVec3::ZERO {
        return Ok(None);
    }
    let what = match operation.is_old {
        true => "is normalized, as in Mitsuba 0.6; Mitsuba 3 scales the shape",
        false => "scales the shape, as in Mitsuba 3; give the axis the length 1 to rotate only",
    };
    Ok(Some(format!(
        "{}: the axis of this <rotate> has the length {:.4}. It {what}",
        operation.location,
        axis.length()
    )))
}

/// Reads a transform from camera to world: `+z` looks from origin to target, `+x` points to the left of the picture.
fn parse_lookat(element: &Element) -> Result<DMat4> {
    let point = |name: &str| Ok(DVec3::from(numbers::three(element, element.required(name)?)?));
    let (origin, target, up) = (point("origin")?, point("target")?, point("up")?);
    let forward = (target - origin).try_normalize().ok_or_else(|| element.error("<lookat>: origin equals target"))?;
    let left = (up.cross(forward))
        .try_normalize()
        .ok_or_else(|| element.error("<lookat>: `up` is zero or parallel to the viewing direction"))?;
    let up = forward.cross(left);
    Ok(DMat4::from_cols(left.extend(0.0), up.extend(0.0), forward.extend(0.0), origin.extend(1.0)))
}

fn parse_matrix(element: &Element) -> Result<DMat4> {
    let values = numbers::list(element, element.required("value")?)?;
    if let Ok(rows) = <&[f64; 9]>::try_from(&values[..]) {
        return Ok(DMat4::from_mat3(DMat3::from_cols_array(rows).transpose()));
    }
    let rows = <&[f64; 16]>::try_from(&values[..])
        .map_err(|_| element.error(format!("a <matrix> has 16 or 9 numbers, not {}", values.len())))?;
    let matrix = DMat4::from_cols_array(rows).transpose();
    if matrix.row(3) != DVec4::W {
        return Err(element.error("the last row of a <matrix> must be 0 0 0 1"));
    }
    Ok(matrix)
}

/// Transform of normals for points that are transformed by `matrix`: the inverse transpose up to a positive factor. It
/// is made of cofactors, so that it exists for a flattening matrix too.
pub(super) fn normal_matrix(matrix: &DMat4) -> DMat3 {
    let [x, y, z] = axes(matrix);
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if is_mirrored(matrix) { -cofactors } else { cofactors }
}

/// Whether the matrix turns right-handed frames into left-handed ones.
pub(super) fn is_mirrored(matrix: &DMat4) -> bool {
    let [x, y, z] = axes(matrix);
    x.cross(y).dot(z) < 0.0
}

/// Images of the unit axes.
pub(super) fn axes(matrix: &DMat4) -> [DVec3; 3] {
    [matrix.x_axis.truncate(), matrix.y_axis.truncate(), matrix.z_axis.truncate()]
}

/// Whether the three axes are orthogonal and equally long, to within `tolerance` of their length.
pub(super) fn is_similarity(matrix: &DMat4, tolerance: f64) -> bool {
    let [x, y, z] = axes(matrix);
    let limit = tolerance * x.length_squared();
    let even = |axis: DVec3| (axis.length_squared() - x.length_squared()).abs() <= 2.0 * limit;
    even(y) && even(z) && [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cosine| cosine.abs() <= limit)
}

/// Linear part of a matrix, made exactly orthogonal; `None` where it is not orthogonal to the precision of printed
/// scene files.
pub(super) fn orthogonal(matrix: &DMat4) -> Option<Mat3> {
    let [x, y, z] = axes(matrix);
    if !is_similarity(matrix, 1.0e-3) || (x.length() - 1.0).abs() > 1.0e-3 {
        return None;
    }
    let x = x.normalize();
    let y = (y - y.dot(x) * x).normalize();
    let z = x.cross(y) * x.cross(y).dot(z).signum();
    Some(Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()))
}
