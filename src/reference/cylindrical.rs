//! Twin of `glsl/include/math/cylindrical.glsl`: Lambert's cylindrical map between the square [-1, 1]^2 and the sphere.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, dvec2, dvec3};

/// Unit direction of a point of the square.
pub fn cylinder_to_sphere(p: DVec2) -> DVec3 {
    let (phi, planar) = (PI * p.x, (1.0 - p.y * p.y).max(0.0).sqrt());
    dvec3(planar * phi.cos(), planar * phi.sin(), p.y)
}

/// Point of the square of a unit direction.
pub fn sphere_to_cylinder(w: DVec3) -> DVec2 {
    dvec2(w.y.atan2(w.x) / PI, w.z)
}

/// The point whose direction is opposite to that of `p`.
pub fn cylinder_antipode(p: DVec2) -> DVec2 {
    dvec2(if p.x < 0.0 { p.x + 1.0 } else { p.x - 1.0 }, -p.y)
}
