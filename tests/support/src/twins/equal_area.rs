//! Twin of `glsl/include/math/equal_area.glsl`: the equal-area map from the sphere to the square [-1, 1]^2. The inverse
//! is [`square_to_sphere`].

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3, dvec2};
use lodestar::math::equal_area::square_to_sphere;

/// Point of the square for a unit direction.
pub fn sphere_to_square(w: DVec3) -> DVec2 {
    let r = ((w.x * w.x + w.y * w.y) / (1.0 + w.z.abs())).sqrt();
    let v = r * w.y.abs().atan2(w.x.abs()) / FRAC_PI_2;
    let upper = dvec2(r - v, v);
    let p = if w.z < 0.0 { dvec2(1.0 - upper.y, 1.0 - upper.x) } else { upper };
    dvec2(p.x.copysign(w.x), p.y.copysign(w.y))
}

/// Point whose direction is opposite to that of `p`.
pub fn antipode(p: DVec2) -> DVec2 {
    sphere_to_square(-square_to_sphere(p))
}

/// Bin of a point of the square, with `resolution` bins along each side, row by row.
pub fn square_bin(p: DVec2, resolution: u32) -> u32 {
    let cell = |x: f64| ((0.5 * x + 0.5) * f64::from(resolution)).clamp(0.0, f64::from(resolution) - 0.5) as u32;
    cell(p.y) * resolution + cell(p.x)
}
