//! Twin of `glsl/include/math/cylindrical.glsl`: Lambert's cylindrical map from the sphere to the square [-1, 1]^2. The
//! inverse is [`lodestar::math::cylindrical::cylinder_to_sphere`].

use std::f64::consts::PI;

use glam::{DVec2, DVec3, dvec2};

/// Point of the square for a unit direction.
pub fn sphere_to_cylinder(w: DVec3) -> DVec2 {
    dvec2(w.y.atan2(w.x) / PI, w.z)
}

/// Point whose direction is opposite to that of `p`.
pub fn cylinder_antipode(p: DVec2) -> DVec2 {
    dvec2(if p.x < 0.0 { p.x + 1.0 } else { p.x - 1.0 }, -p.y)
}
