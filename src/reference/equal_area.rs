//! Twin of `glsl/include/math/equal_area.glsl`: the equal-area map between the square [-1, 1]^2 and the sphere.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DVec2, DVec3, dvec2, dvec3};

/// Unit direction of a point of the square.
pub fn square_to_sphere(p: DVec2) -> DVec3 {
    let a = p.abs();
    let signed_distance = 1.0 - (a.x + a.y);
    let r = 1.0 - signed_distance.abs();
    let phi = if r == 0.0 { 0.0 } else { FRAC_PI_4 * ((a.y - a.x) / r + 1.0) };
    let planar = r * (2.0 - r * r).max(0.0).sqrt();
    dvec3(
        (planar * phi.cos()).copysign(p.x),
        (planar * phi.sin()).copysign(p.y),
        (1.0 - r * r).copysign(signed_distance),
    )
}

/// Point of the square of a unit direction.
pub fn sphere_to_square(w: DVec3) -> DVec2 {
    let r = ((w.x * w.x + w.y * w.y) / (1.0 + w.z.abs())).sqrt();
    let v = r * w.y.abs().atan2(w.x.abs()) / FRAC_PI_2;
    let upper = dvec2(r - v, v);
    let p = if w.z < 0.0 { dvec2(1.0 - upper.y, 1.0 - upper.x) } else { upper };
    dvec2(p.x.copysign(w.x), p.y.copysign(w.y))
}

/// The point whose direction is opposite to that of `p`.
pub fn antipode(p: DVec2) -> DVec2 {
    sphere_to_square(-square_to_sphere(p))
}

/// Bin of a point of the square at `resolution` bins a side, row by row.
pub fn square_bin(p: DVec2, resolution: u32) -> u32 {
    let cell = |x: f64| ((0.5 * x + 0.5) * f64::from(resolution)).clamp(0.0, f64::from(resolution) - 0.5) as u32;
    cell(p.y) * resolution + cell(p.x)
}
