//! Twin of `glsl/include/math/microfacet.glsl`, tested against known results.

use support::twins::microfacet::erf;

#[test]
fn error_functions_are_the_tabulated_ones() {
    for (x, expected) in [
        (0.5, 0.520_499_877_813_046_5),
        (1.0, 0.842_700_792_949_714_9),
        (2.0, 0.995_322_265_018_952_7),
        (2.99, 0.999_976_474_396_919_4),
        (3.5, 0.999_999_256_901_627_7),
    ] {
        assert!((erf(x) - expected).abs() < 1.0e-13, "erf({x}) = {}", erf(x));
        assert_eq!(erf(-x), -erf(x));
    }
}
