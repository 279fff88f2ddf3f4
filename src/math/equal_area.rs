//! The equal-area map from the square [-1, 1]^2 to the unit sphere (Shirley and Chiu 1997; Clarberg 2008). GLSL:
//! `glsl/include/math/equal_area.glsl`.

use std::f64::consts::FRAC_PI_4;

use glam::{DVec2, DVec3, dvec3};

/// Unit direction of a point of the square [-1, 1]^2. Points with |x| + |y| < 1 are above the xy-plane, the corners below.
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
