//! Planes of flat shapes. A plane is measured from an anchor: the shape's origin, or the world's for a shape that is large
//! beside its distance from there. Rays near the world's origin then meet a huge ground without the roundings of its
//! far corners.

use glam::{DVec3, Vec3};

use crate::scene::{Primitive, PrimitiveShape};

/// Constant of the plane's equation relative to the anchor, and whether the anchor is the world's origin. `longest` is the
/// shape's longest edge.
pub(super) fn equation(p: &Primitive, longest: f32) -> (f32, bool) {
    if p.shape.is_round() || is_far(p, longest) {
        return (0.0, false);
    }
    let nearest = nearest_point(p);
    // The kernels compute the same normal to the last bit. So their plane runs through the point, where a plane through
    // a far corner would pass the point at the distance of a rounding of that corner.
    let plane = p.edge_u.cross(p.edge_v).as_dvec3().dot(nearest);
    let large = 2.0 * nearest.length() < f64::from(longest);
    (if large { plane as f32 } else { 0.0 }, large)
}

/// Whether the shape is surely not large, because its origin is far from the world's. Most shapes are far, and their nearest
/// point need not be found. No point of a shape is farther from its origin than twice its longest edge.
fn is_far(p: &Primitive, longest: f32) -> bool {
    2.5 * longest < 0.999 * p.origin.length()
}

/// A point of the flat shape that is no farther from the world's origin than most: the nearest one of a triangle or
/// rectangle.
fn nearest_point(p: &Primitive) -> DVec3 {
    let [origin, edge_u, edge_v] = [p.origin, p.edge_u, p.edge_v].map(Vec3::as_dvec3);
    let [uu, uv, vv] = [edge_u.dot(edge_u), edge_u.dot(edge_v), edge_v.dot(edge_v)];
    let [to_u, to_v] = [-origin.dot(edge_u), -origin.dot(edge_v)];
    let determinant = uu * vv - uv * uv;
    let [u, v] = match determinant > 0.0 {
        true => [(to_u * vv - to_v * uv) / determinant, (to_v * uu - to_u * uv) / determinant],
        false => [0.0; 2],
    };
    let at = |u: f64, v: f64| origin + u * edge_u + v * edge_v;
    match p.shape {
        PrimitiveShape::Triangle if u >= 0.0 && v >= 0.0 && u + v <= 1.0 => at(u, v),
        PrimitiveShape::Triangle => {
            let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
            let sides = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| nearest_of_segment(corners[a], corners[b]));
            sides.into_iter().min_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(origin)
        }
        PrimitiveShape::Disk => at(u / u.hypot(v).max(1.0), v / u.hypot(v).max(1.0)),
        PrimitiveShape::Parallelogram | PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => {
            at(u.clamp(-1.0, 1.0), v.clamp(-1.0, 1.0))
        }
    }
}

/// Point of a segment that is nearest to the world's origin.
fn nearest_of_segment(a: DVec3, b: DVec3) -> DVec3 {
    let edge = b - a;
    a + (-a.dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) * edge
}
