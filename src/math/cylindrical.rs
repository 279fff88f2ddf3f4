//! Lambert's cylindrical map (1772) from the square [-1, 1]^2 to the unit sphere. Equal areas of the square become equal solid
//! angles. GLSL: `glsl/include/math/cylindrical.glsl`.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, dvec3};

/// Unit direction of a point of the square [-1, 1]^2: x is the azimuth in half turns from +x towards +y, y the height.
pub fn cylinder_to_sphere(p: DVec2) -> DVec3 {
    let (phi, planar) = (PI * p.x, (1.0 - p.y * p.y).max(0.0).sqrt());
    dvec3(planar * phi.cos(), planar * phi.sin(), p.y)
}
