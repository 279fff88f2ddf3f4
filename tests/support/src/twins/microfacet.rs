//! Twin of `glsl/include/math/microfacet.glsl`. Facets and their approximate masking are in
//! [`lodestar::math::microfacet`].

use std::f64::consts::PI;

use glam::DVec3;
use lodestar::math::microfacet::{Microfacets, smith_g1};

/// Squared tangent of the angle from the z-axis.
fn tan2(x: f64, y: f64, z: f64) -> f64 {
    (x * x + y * y) / (z * z)
}

/// Density D(m) of normals, per unit of area and steradian.
pub fn microfacet_density(s: &Microfacets, m: DVec3) -> f64 {
    if m.z <= 0.0 {
        return 0.0;
    }
    let t = tan2(m.x / s.alpha[0], m.y / s.alpha[1], m.z);
    let of_slopes = if s.is_ggx { (1.0 + t).powi(-2) } else { (-t).exp() };
    of_slopes / (PI * s.alpha[0] * s.alpha[1] * m.z.powi(4))
}

/// Exact masking G1 by Smith, for either distribution.
pub fn exact_g1(s: &Microfacets, v: DVec3) -> f64 {
    if s.is_ggx {
        return smith_g1(s, v);
    }
    let a = tan2(v.x * s.alpha[0], v.y * s.alpha[1], v.z).sqrt().recip();
    if a > 20.0 { 1.0 } else { 2.0 / (1.0 + erf(a) + (-a * a).exp() / (a * PI.sqrt())) }
}

/// Density of a facet's normal as seen from `v` on the upper side.
pub fn pdf_visible_normal(s: &Microfacets, v: DVec3, m: DVec3) -> f64 {
    exact_g1(s, v) * v.dot(m).max(0.0) * microfacet_density(s, m) / v.z
}

/// Error function in double precision: a series for small x, Lentz's continued fraction for large x.
pub fn erf(x: f64) -> f64 {
    if x.abs() > 3.0 {
        return x.signum() * (1.0 - erfc_fraction(x.abs()));
    }
    let mut term = x;
    let mut sum = x;
    for n in 1..200 {
        term *= -x * x / f64::from(n);
        sum += term / f64::from(2 * n + 1);
    }
    2.0 / PI.sqrt() * sum
}

/// Function erfc for x > 3: a continued fraction, evaluated from its end.
fn erfc_fraction(x: f64) -> f64 {
    let tail = (1..100).rev().fold(x, |tail, n| x + 0.5 * f64::from(n) / tail);
    (-x * x).exp() / (PI.sqrt() * tail)
}
