//! Twin of `glsl/include/geometry/intersect.glsl`. By testing every primitive, it is also the twin of
//! `glsl/include/geometry/traverse.glsl`.

use glam::DVec3;
use lodestar::scene::{Primitive, PrimitiveShape};

/// Ray with a unit direction.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Start of the ray.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Length of the ray.
    pub t_max: f64,
}

/// Point where a line crosses a primitive or its plane.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Distance along the ray. It may be negative.
    pub t: f64,
    /// Distance from the outline, relative to the primitive: 0 on the outline, negative outside, about 1 in the middle.
    pub inside: f64,
    /// Distance from grazing incidence: the sine of the angle to a plane (1 if the shape's edges are at right angles,
    /// too), or to the shading normal where only the front is solid. A sphere's outline is where rays graze it, so its value is
    /// `inside`.
    pub steepness: f64,
}

/// Cosine within which rounding decides whether a ray meets a front.
const GRAZING: f64 = 1.0e-3;

/// A disk that faces what it lights, as the flat disk that it is for light that arrives at `to`.
pub fn turned(p: &Primitive, to: DVec3) -> Primitive {
    if !matches!(p.shape, PrimitiveShape::FacingDisk) {
        return *p;
    }
    let (edge_u, edge_v) = (to - p.origin.as_dvec3()).normalize().any_orthonormal_pair();
    let [edge_u, edge_v] = [edge_u, edge_v].map(|edge| (f64::from(p.edge_u.length()) * edge).as_vec3());
    Primitive { shape: PrimitiveShape::Disk, edge_u, edge_v, ..*p }
}

/// All crossings of the line with the primitive or its plane.
pub fn crossings(ray: &Ray, p: &Primitive) -> Vec<Crossing> {
    match p.shape {
        PrimitiveShape::Sphere => sphere_crossings(ray, p),
        PrimitiveShape::FacingDisk => flat_crossing(ray, &turned(p, ray.origin)).into_iter().collect(),
        _ => flat_crossing(ray, p).into_iter().collect(),
    }
}

fn flat_crossing(ray: &Ray, p: &Primitive) -> Option<Crossing> {
    let (edge_u, edge_v) = (p.edge_u.as_dvec3(), p.edge_v.as_dvec3());
    let area = edge_u.cross(edge_v);
    let determinant = -ray.direction.dot(area);
    if determinant == 0.0 {
        return None;
    }
    let offset = ray.origin - p.origin.as_dvec3();
    let t = offset.dot(area) / determinant;
    // Coordinates in the plane, by Cramer's rule.
    let at = offset + t * ray.direction;
    let u = at.cross(edge_v).dot(area) / area.length_squared();
    let v = edge_u.cross(at).dot(area) / area.length_squared();
    let facing = -front_at(p, area, u, v).normalize().dot(ray.direction);
    if p.front_only && facing < -GRAZING {
        return None;
    }
    let inside = match p.shape {
        PrimitiveShape::Triangle => u.min(v).min(1.0 - u - v),
        PrimitiveShape::Parallelogram => 1.0 - u.abs().max(v.abs()),
        PrimitiveShape::Disk => 1.0 - u.hypot(v),
        PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => unreachable!("a round shape is not flat"),
    };
    let longest = edge_u.length().max(edge_v.length());
    let of_plane = determinant.abs() / longest.powi(2);
    Some(Crossing { t, inside, steepness: if p.front_only { of_plane.min(facing.abs()) } else { of_plane } })
}

/// Direction to the front of a flat shape, of any length: the normal that the vertices give, else the geometric normal.
fn front_at(p: &Primitive, area: DVec3, u: f64, v: f64) -> DVec3 {
    let geometric = if p.flip_normal { -area } else { area };
    p.normals.map_or(geometric, |[a, b, c]| (1.0 - u - v) * a.as_dvec3() + u * b.as_dvec3() + v * c.as_dvec3())
}

fn sphere_crossings(ray: &Ray, p: &Primitive) -> Vec<Crossing> {
    let radius = p.edge_u.as_dvec3().length();
    let offset = ray.origin - p.origin.as_dvec3();
    let middle = -offset.dot(ray.direction);
    let inside = 1.0 - (offset + middle * ray.direction).length_squared() / radius.powi(2);
    if radius == 0.0 {
        return Vec::new();
    }
    let half = radius * inside.max(0.0).sqrt();
    [middle - half, middle + half].map(|t| Crossing { t, inside, steepness: inside }).to_vec()
}

/// Distance and index of the nearest hit, by trying every primitive.
pub fn traverse(ray: &Ray, primitives: &[Primitive]) -> Option<(f64, usize)> {
    let hits = primitives.iter().enumerate().flat_map(|(index, p)| {
        let hits = crossings(ray, p).into_iter().filter(|c| c.inside >= 0.0 && c.t > 0.0 && c.t < ray.t_max);
        hits.map(move |c| (c.t, index))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}
