//! P-values of deviations.

use statrs::function::erf::erfc;

/// Probability that one family of tests rejects a correct renderer.
pub const ALPHA: f64 = 0.01;

/// Probability that a standard normal variable is farther from 0 than `z`.
pub fn two_sided(z: f64) -> f64 {
    erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// P-value of the smallest of `count` independent p-values (Sidak 1967).
pub fn sidak(smallest: f64, count: usize) -> f64 {
    -(count as f64 * (-smallest).ln_1p()).exp_m1()
}
