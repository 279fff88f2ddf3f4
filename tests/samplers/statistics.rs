//! Statistics that the suites share, in cases with known results.

use support::statistics::{Numbers, chi_square, sidak, uniformity};

#[test]
fn the_chi_square_knows_good_from_bad() {
    let mut numbers = Numbers::new(1);
    let values: Vec<f64> = (0..1 << 18).map(|_| numbers.unit()).collect();
    assert!(uniformity(values.iter().copied(), 256) > 1e-3);
    assert!(uniformity(values.iter().map(|v| v.powf(1.05)), 256) < 1e-12);
    // The twins must fail: samples in cells that should be empty, and a total that is too small.
    assert!(chi_square(&[500, 500, 40, 40], &[500.0, 500.0, 0.0, 1.0]) < 1e-12);
    assert!(chi_square(&[500; 100], &[550.0; 100]) < 1e-12);
    assert!(chi_square(&[500; 100], &[501.0; 100]) > 0.5);
}

#[test]
fn sidak_is_nearly_bonferroni() {
    assert!((sidak(0.01, 100) - 1.0e-4).abs() < 1.0e-6);
}
