//! Twin of `glsl/include/math/direction.glsl`.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DMat3, DVec2, DVec3, dvec2};

/// Sine and cosine of `x`.
pub fn sin_cos_quarter(x: f64) -> DVec2 {
    dvec2(x.sin(), x.cos())
}

/// Right-handed orthonormal basis whose z-axis is `n` (Duff et al. 2017).
pub fn basis_from_normal(n: DVec3) -> DMat3 {
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    let x = DVec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    DMat3::from_cols(x, DVec3::new(b, s + n.y * n.y * a, -n.y), n)
}

/// Point of the unit disk for a point of the unit square (Shirley and Chiu 1997).
pub fn concentric_disk(u: DVec2) -> DVec2 {
    let p = 2.0 * u - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * p.y / p.x)
    } else {
        (p.y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * p.x / p.y)
    };
    radius * dvec2(angle.cos(), angle.sin())
}

/// Direction about +z with density cos / pi.
pub fn sample_cosine_hemisphere(u: DVec2) -> DVec3 {
    let d = concentric_disk(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`sample_cosine_hemisphere`], per steradian.
pub fn pdf_cosine_hemisphere(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) / PI
}
