//! How surprising a deviation is.

use statrs::function::erf::erfc;

/// Chance with which one family of tests rejects what is right.
pub const ALPHA: f64 = 0.01;

/// Probability that a standard normal variable is farther from 0 than `z`.
pub fn two_sided(z: f64) -> f64 {
    erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// The p-value of the smallest of `count` independent p-values (Sidak 1967).
pub fn sidak(smallest: f64, count: usize) -> f64 {
    -(count as f64 * (-smallest).ln_1p()).exp_m1()
}

#[test]
fn agree_with_tables() {
    assert!((two_sided(1.959_964) - 0.05).abs() < 1.0e-7);
    assert!((two_sided(-3.290_527) - 0.001).abs() < 1.0e-8);
    assert_eq!(two_sided(f64::INFINITY), 0.0);
    assert!((sidak(0.05, 2) - 0.0975).abs() < 1.0e-12);
    assert!((sidak(1.0e-18, 1000) / 1.0e-15 - 1.0).abs() < 1.0e-9);
    assert_eq!(sidak(1.0, 3), 1.0);
}
