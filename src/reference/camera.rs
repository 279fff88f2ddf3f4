//! Twin of the filters in `glsl/include/camera.glsl`.

use std::f64::consts::TAU;

use glam::{DVec2, dvec2};

/// Inverse of the cumulative tent on [-1, 1].
pub fn sample_tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// A Gaussian of unit deviation, cut off at a distance of four.
pub fn sample_gaussian(u: DVec2) -> DVec2 {
    let inside = 1.0 - (-8.0_f64).exp();
    let radius = (-2.0 * (-inside * u.x).ln_1p()).sqrt();
    radius * dvec2((TAU * u.y).cos(), (TAU * u.y).sin())
}
