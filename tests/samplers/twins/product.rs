//! Twin of `glsl/include/guide/samplers/product.glsl`, tested against known results.

use support::twins::product::{LARGEST, LEAST_7, LEAST_8, Product, small_float};

#[test]
fn small_floats_are_within_a_sixteenth() {
    for i in 0..20_000 {
        let x = 1.0e-9 * 1.001_f64.powi(i);
        if x <= LARGEST {
            assert!((small_float(x, LEAST_8) / x - 1.0).abs() <= 1.0 / 16.0, "{x}");
        }
    }
    assert_eq!(small_float(0.0, LEAST_7), LEAST_7);
    assert_eq!(small_float(1.0, LEAST_7), 1.0);
    assert_eq!(small_float(1.06, LEAST_7), 1.0);
    assert_eq!(small_float(1.07, LEAST_7), 1.125);
    assert_eq!(small_float(0.99, LEAST_7), 1.0);
}

#[test]
fn probabilities_add_up_and_follow_the_product() {
    for side in [16_usize, 32, 64] {
        let bins = side * side;
        let radiance: Vec<f32> = (0..bins).map(|bin| 1.0 + (bin * 37 % 101) as f32).collect();
        let integrals: Vec<f64> = (0..bins).map(|bin| 0.1 + (bin % 5) as f64).collect();
        let product = Product { radiance: &radiance, integrals: &integrals };
        let sum: f64 = (0..bins).map(|bin| product.probability(bin)).sum();
        assert!((sum - 1.0).abs() < 1.0e-12, "{side}: {sum}");
        if side == 16 {
            let total: f64 = (0..bins).map(|bin| f64::from(radiance[bin]) * integrals[bin]).sum();
            for (bin, integral) in integrals.iter().enumerate() {
                let exact = f64::from(radiance[bin]) * integral / total;
                let ratio = product.probability(bin) / exact;
                // The ratio has three rounding errors of a sixteenth, and those of the sums.
                assert!((0.75..1.33).contains(&ratio), "{bin}: {ratio}");
            }
        }
    }
}
