//! Surfaces of revolution around the z-axis as triangles, with their normals and pbrt's texture coordinates.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::scene::mesh::Mesh;

/// Number of strips around a whole circle.
const STRIPS: usize = 128;
/// Number of rings from pole to pole of a sphere.
const RINGS: usize = 64;

/// Part of a sphere around the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sphere {
    pub radius: f64,
    /// Smallest z.
    pub low: f64,
    /// Largest z.
    pub high: f64,
    /// Angle up to which it reaches, in radians.
    pub angle: f64,
}

impl Sphere {
    /// Whole sphere.
    pub fn whole(radius: f64) -> Self {
        Self { radius, low: -radius, high: radius, angle: TAU }
    }
}

/// Part of a disk that faces `+z`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disk {
    pub radius: f64,
    /// Radius of the hole.
    pub inner: f64,
    /// The disk's z.
    pub height: f64,
    /// Angle up to which it reaches, in radians.
    pub angle: f64,
}

/// Cylinder without caps that faces outward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cylinder {
    pub radius: f64,
    /// Smallest z.
    pub low: f64,
    /// Largest z.
    pub high: f64,
    /// Angle up to which it reaches, in radians.
    pub angle: f64,
}

/// Triangles of a sphere. `v` runs from the lowest z up.
pub(super) fn sphere(sphere: &Sphere) -> Mesh {
    let polar = |z: f64| (z / sphere.radius).clamp(-1.0, 1.0).acos();
    let (first, last) = (polar(sphere.low), polar(sphere.high));
    let rings = (RINGS as f64 * (first - last).abs() / PI).ceil().max(1.0) as usize;
    grid(sphere.angle, rings, |around, v| {
        let cosine = (first + v * (last - first)).cos();
        // It is 0 at both poles, where triangles have no area.
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let normal = DVec3::new(around.x * sine, around.y * sine, cosine);
        (sphere.radius * normal, normal)
    })
}

/// Triangles of a disk. `v` runs from the rim to the center.
pub(super) fn disk(disk: &Disk) -> Mesh {
    grid(disk.angle, 1, |around, v| {
        let radius = disk.radius + v * (disk.inner - disk.radius);
        ((radius * around).extend(disk.height), DVec3::Z)
    })
}

/// Triangles of a cylinder. `v` runs from the lowest z up.
pub(super) fn cylinder(cylinder: &Cylinder) -> Mesh {
    grid(cylinder.angle, 1, |around, v| {
        let z = cylinder.low + v * (cylinder.high - cylinder.low);
        ((cylinder.radius * around).extend(z), around.extend(0.0))
    })
}

/// Grid of triangles over the angle and `v`. `point` gives position and normal at a direction around the axis and at `v`.
fn grid(angle: f64, rings: usize, point: impl Fn(DVec2, f64) -> (DVec3, DVec3)) -> Mesh {
    let strips = ((STRIPS as f64 * angle / TAU).ceil() as usize).clamp(1, STRIPS);
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        let v = ring as f64 / rings as f64;
        for strip in 0..=strips {
            let u = strip as f64 / strips as f64;
            let (position, normal) = point(DVec2::from_angle(u * angle), v);
            mesh.positions.push(position.as_vec3());
            mesh.normals.push(normal.as_vec3());
            mesh.uvs.push(DVec2::new(u, v).as_vec2());
        }
    }
    let row = strips as u32 + 1;
    for corner in (0..rings as u32).flat_map(|ring| (0..strips as u32).map(move |strip| ring * row + strip)) {
        mesh.triangles.push([corner, corner + 1, corner + row + 1]);
        mesh.triangles.push([corner, corner + row + 1, corner + row]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat4;

    /// Areas by closed form; triangles lie inside of what they stand for, so their area is a little smaller.
    #[test]
    fn areas_are_those_of_the_surfaces() {
        let close = |mesh: &Mesh, expected: f64| {
            let area: f64 = super::super::form::triangle_areas(mesh, &DMat4::IDENTITY).iter().sum();
            assert!(area <= expected && area > 0.998 * expected, "{area} is not {expected}");
            assert_eq!((mesh.normals.len(), mesh.uvs.len()), (mesh.positions.len(), mesh.positions.len()));
        };
        close(&sphere(&Sphere::whole(2.0)), 16.0 * PI);
        // A zone of a sphere: 2 pi r h, of a quarter turn.
        close(&sphere(&Sphere { radius: 2.0, low: -1.0, high: 0.5, angle: PI / 2.0 }), PI / 2.0 * 2.0 * 1.5);
        close(&disk(&Disk { radius: 3.0, inner: 1.0, height: 5.0, angle: TAU }), 8.0 * PI);
        close(&cylinder(&Cylinder { radius: 0.5, low: 1.0, high: 3.0, angle: PI }), PI * 0.5 * 2.0);
    }
}
