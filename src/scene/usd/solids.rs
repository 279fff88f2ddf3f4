//! Shapes that are given by their measures: `Sphere`, `Cube`, `Cylinder`, `Cone`, `Capsule` and `Plane`.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat4, DVec2, DVec3};

use super::asset::Prim;
use crate::Result;
use crate::scene::mesh::Mesh;

/// Columns of round shapes.
const COLUMNS: usize = 64;
/// Rows of a quarter of a sphere.
const ROWS: usize = 16;

/// Whether a type of prims is a solid.
pub(super) fn is_solid(kind: &str) -> bool {
    matches!(kind, "Sphere" | "Cube" | "Cylinder" | "Cylinder_1" | "Cone" | "Capsule" | "Capsule_1" | "Plane")
}

/// A solid, to be placed by its transform.
pub(super) enum Solid {
    /// A sphere of this radius.
    Sphere(f64),
    Mesh(Mesh),
}

/// Reads a solid.
pub(super) fn solid(prim: &Prim) -> Result<Solid> {
    let measure = |name: &str, default: f64| -> Result<f64> { Ok(prim.number(name, default)?.abs()) };
    let radius: f64 = measure("radius", if matches!(&*prim.kind, "Capsule" | "Capsule_1") { 0.5 } else { 1.0 })?;
    let top = if prim.has("radiusTop") { measure("radiusTop", radius)? } else { radius };
    let bottom = if prim.has("radiusBottom") { measure("radiusBottom", radius)? } else { radius };
    let height: f64 = measure("height", if matches!(&*prim.kind, "Capsule" | "Capsule_1") { 1.0 } else { 2.0 })?;
    let half = 0.5 * height;
    let at = |radius: f64, height: f64| DVec2::new(radius, height);
    let profile = match &*prim.kind {
        "Sphere" => return Ok(Solid::Sphere(radius)),
        "Cube" => return Ok(Solid::Mesh(cube(0.5 * measure("size", 2.0)?))),
        "Plane" => {
            let [width, length]: [f64; 2] = [measure("width", 2.0)?, measure("length", 2.0)?];
            let mut mesh = plane(0.5 * width, 0.5 * length);
            turn(&mut mesh, &plane_axis(prim)?);
            return Ok(Solid::Mesh(mesh));
        }
        "Cone" => vec![vec![at(0.0, -half), at(radius, -half)], vec![at(radius, -half), at(0.0, half)]],
        "Capsule" | "Capsule_1" => {
            let arc = |step: usize| FRAC_PI_2 * (step as f64 / ROWS as f64);
            let below = (0..=ROWS).map(|step| at(bottom * arc(step).sin(), -half - bottom * arc(step).cos()));
            let above = (0..=ROWS).map(|step| at(top * arc(step).cos(), half + top * arc(step).sin()));
            vec![below.chain(above).collect()]
        }
        _ => vec![
            vec![at(0.0, -half), at(bottom, -half)],
            vec![at(bottom, -half), at(top, half)],
            vec![at(top, half), at(0.0, half)],
        ],
    };
    let mut mesh = Mesh::default();
    profile.iter().for_each(|line| revolve(&mut mesh, line));
    turn(&mut mesh, &axis(prim)?);
    Ok(Solid::Mesh(mesh))
}

/// Transform of `+z` to the axis of a prim.
fn axis(prim: &Prim) -> Result<DMat4> {
    Ok(match prim.text("axis")?.as_deref() {
        Some("X") => DMat4::from_cols(DVec3::Y.extend(0.0), DVec3::Z.extend(0.0), DVec3::X.extend(0.0), glam::DVec4::W),
        Some("Y") => DMat4::from_cols(DVec3::Z.extend(0.0), DVec3::X.extend(0.0), DVec3::Y.extend(0.0), glam::DVec4::W),
        _ => DMat4::IDENTITY,
    })
}

/// Transform of a plane in x and y to that about the axis of a prim.
fn plane_axis(prim: &Prim) -> Result<DMat4> {
    let [x, y, z] = DVec3::AXES.map(|axis| axis.extend(0.0));
    Ok(match prim.text("axis")?.as_deref() {
        Some("X") => DMat4::from_cols(-z, y, x, glam::DVec4::W),
        Some("Y") => DMat4::from_cols(x, -z, y, glam::DVec4::W),
        _ => DMat4::IDENTITY,
    })
}

fn turn(mesh: &mut Mesh, by: &DMat4) {
    for vector in mesh.positions.iter_mut().chain(&mut mesh.normals) {
        *vector = by.transform_vector3(vector.as_dvec3()).as_vec3();
    }
}

/// Adds the surface of a line of radii and heights that turns about the z-axis, with smooth normals along the line.
fn revolve(mesh: &mut Mesh, line: &[DVec2]) {
    let first = mesh.positions.len() as u32;
    let rows = line.len();
    for column in 0..=COLUMNS {
        let share = column as f64 / COLUMNS as f64;
        let (sine, cosine) = (TAU * share).sin_cos();
        for (row, place) in line.iter().enumerate() {
            let along = line[(row + 1).min(rows - 1)] - line[row.saturating_sub(1)];
            // A line upward has its outside to the right.
            let outward = DVec2::new(along.y, -along.x).normalize_or_zero();
            let around = |radius: f64, height: f64| DVec3::new(radius * cosine, radius * sine, height).as_vec3();
            mesh.positions.push(around(place.x, place.y));
            mesh.normals.push(around(outward.x, outward.y));
            mesh.uvs.push(glam::Vec2::new(share as f32, 1.0 - row as f32 / (rows - 1) as f32));
        }
    }
    let rows = rows as u32;
    for column in 0..COLUMNS as u32 {
        for row in 0..rows - 1 {
            let corner = |column: u32, row: u32| first + column * rows + row;
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| corner(column + x, row + y));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

fn plane(half_width: f64, half_length: f64) -> Mesh {
    let mut mesh = Mesh::default();
    quad(&mut mesh, DVec3::ZERO, DVec3::X * half_width, DVec3::Y * half_length);
    mesh
}

fn cube(half: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let [x, y, z] = DVec3::AXES.map(|axis| axis * half);
    for (outward, u, v) in [(x, y, z), (-x, -y, z), (y, -x, z), (-y, x, z), (z, x, y), (-z, x, -y)] {
        quad(&mut mesh, outward, u, v);
    }
    mesh
}

fn quad(mesh: &mut Mesh, center: DVec3, u: DVec3, v: DVec3) {
    let first = mesh.positions.len() as u32;
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        mesh.positions.push((center + x * u + y * v).as_vec3());
        mesh.normals.push(u.cross(v).normalize_or_zero().as_vec3());
        mesh.uvs.push(glam::Vec2::new(0.5 + 0.5 * x as f32, 0.5 - 0.5 * y as f32));
    }
    mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle: [u32; 3]| triangle.map(|index| first + index)));
}

/// Sphere of triangles.
pub(super) fn sphere(radius: f64) -> Mesh {
    let arc = |step: usize| FRAC_PI_2 * (step as f64 / ROWS as f64);
    let line: Vec<_> =
        (0..=2 * ROWS).map(|step| DVec2::new(radius * arc(step).sin(), -radius * arc(step).cos())).collect();
    let mut mesh = Mesh::default();
    revolve(&mut mesh, &line);
    mesh
}
