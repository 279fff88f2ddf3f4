//! Reader of `cylinder`: the side of a cylinder, without caps, as triangles with the cylinder's own normals.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::{DMat4, DVec3, Vec2, Vec3};

use super::properties::Properties;
use super::transform;
use crate::Result;
use crate::scene::mesh::Mesh;

/// Number of flat strips that stand for the side.
///
/// The strips have the area of the cylinder, so that a lamp has its power. They lie between 1 - 2.0e-4 and 1 + 1.0e-4 radii
/// from the axis.
pub(super) const SEGMENTS: u32 = 128;

/// Largest relative deviation from a circular cylinder: scene files are printed with six digits.
const TOLERANCE: f64 = 1e-3;

/// Triangles of the cylinder of radius 1 around the z axis, from z = 0 to 1.
pub(super) static UNIT: LazyLock<Mesh> = LazyLock::new(|| {
    let half_angle = PI / f64::from(SEGMENTS);
    let radius = half_angle / half_angle.sin();
    let mut mesh = Mesh::default();
    // The last column repeats the first, with u = 1.
    for column in 0..=SEGMENTS {
        let u = f64::from(column) / f64::from(SEGMENTS);
        let (y, x) = (TAU * u).sin_cos();
        for z in [0.0, 1.0] {
            mesh.positions.push(DVec3::new(radius * x, radius * y, z).as_vec3());
            mesh.normals.push(Vec3::new(x as f32, y as f32, 0.0));
            mesh.uvs.push(Vec2::new(u as f32, z as f32));
        }
    }
    for column in 0..SEGMENTS {
        let [below, above, next_below, next_above] = [0, 1, 2, 3].map(|corner| 2 * column + corner);
        mesh.triangles.extend([[below, next_below, next_above], [below, next_above, above]]);
    }
    mesh
});

/// Reads the parameters of a `cylinder`, and returns the transform from [`UNIT`] to the world.
pub(super) fn parse(properties: &mut Properties, to_world: DMat4) -> Result<DMat4> {
    let object = properties.owner();
    let p0 = properties.point("p0")?.unwrap_or(DVec3::ZERO);
    let p1 = properties.point("p1")?.unwrap_or(DVec3::Z);
    let radius = f64::from(properties.positive_float("radius", 1.0)?);
    let length = (p1 - p0).length();
    let axis = (p1 - p0).try_normalize().ok_or_else(|| object.error("the `p0` and `p1` of a cylinder must differ"))?;
    let [x, y] = across(axis);
    let frame = DMat4::from_cols(
        (radius * x).extend(0.0),
        (radius * y).extend(0.0),
        (length * axis).extend(0.0),
        p0.extend(1.0),
    );
    let result = to_world * frame;
    if !is_circular(&result) {
        return Err(object.error("the `to_world` of a cylinder must not scale its circle unevenly or shear"));
    }
    Ok(result)
}

/// Axes of the circle, from the first of which u is counted. Mitsuba 3's frame (Duff et al. 2017).
fn across(axis: DVec3) -> [DVec3; 2] {
    let sign = 1.0_f64.copysign(axis.z);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    [
        DVec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        DVec3::new(b, sign + axis.y * axis.y * a, -axis.y),
    ]
}

/// Whether [`UNIT`] stays a circular cylinder: the axes are orthogonal, and those of the circle equally long.
fn is_circular(matrix: &DMat4) -> bool {
    let [x, y, z] = transform::axes(matrix);
    let [x_length, y_length, z_length] = [x, y, z].map(DVec3::length);
    let is_right = |cosine: f64, lengths: f64| cosine.abs() <= TOLERANCE * lengths;
    (x_length - y_length).abs() <= TOLERANCE * x_length
        && is_right(x.dot(y), x_length * y_length)
        && is_right(y.dot(z), y_length * z_length)
        && is_right(z.dot(x), z_length * x_length)
}
