//! P-values against tables.

use support::significance::{sidak, two_sided};

#[test]
fn agree_with_tables() {
    assert!((two_sided(1.959_964) - 0.05).abs() < 1.0e-7);
    assert!((two_sided(-3.290_527) - 0.001).abs() < 1.0e-8);
    assert_eq!(two_sided(f64::INFINITY), 0.0);
    assert!((sidak(0.05, 2) - 0.0975).abs() < 1.0e-12);
    assert!((sidak(1.0e-18, 1000) / 1.0e-15 - 1.0).abs() < 1.0e-9);
    assert_eq!(sidak(1.0, 3), 1.0);
}
