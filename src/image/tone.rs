//! Tone curves: from linear radiance to display values.

use strum::{EnumMessage, IntoStaticStr, VariantArray};

/// Curve that maps linear values to display values.
#[derive(
    Debug,
    Clone,
    Copy,
    Default,
    PartialEq,
    Eq,
    serde::Serialize,
    serde::Deserialize,
    EnumMessage,
    IntoStaticStr,
    VariantArray,
)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "lowercase")]
pub enum ToneCurve {
    /// The sRGB transfer function; brighter than 1 is white.
    #[default]
    Srgb,
    /// The paper's curve, which compresses highlights by luminance.
    Paper,
}

impl ToneCurve {
    /// Display values in [0, 1] of a linear color.
    pub fn apply(self, color: [f64; 3]) -> [f64; 3] {
        let shown = match self {
            Self::Srgb => color.map(srgb),
            Self::Paper => paper(color),
        };
        shown.map(|value| value.clamp(0.0, 1.0))
    }
}

/// The sRGB transfer function of IEC 61966-2-1.
pub fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The paper's tone curve: `(c / (1 + Y / 1.5))^(1 / 2.2)` with `Y = 0.3 R + 0.6 G + 0.1 B`. Negative values count as
/// 0.
///
/// Results above 1 are possible, because a saturated color may exceed its luminance.
pub fn paper(color: [f64; 3]) -> [f64; 3] {
    // Infinity would give infinity / infinity; 1e30 is shown as white too.
    let color = color.map(|c| c.clamp(0.0, 1e30));
    let luminance = 0.3 * color[0] + 0.6 * color[1] + 0.1 * color[2];
    color.map(|c| (c / (1.0 + luminance / 1.5)).powf(1.0 / 2.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-12, "{value} is not {expected}");
    }

    #[test]
    fn srgb_has_its_two_pieces() {
        assert_close(srgb(0.002), 0.02584);
        // 1.055 * 0.5^(1/2.4) - 0.055
        assert_close(srgb(0.5), 0.735_356_983_052_449_6);
        assert_close(srgb(1.0), 1.0);
        // The two pieces meet to within the rounding of the standard's constants.
        assert!((srgb(0.003_130_8) - srgb(0.003_130_800_01)).abs() < 1e-7);
    }

    #[test]
    fn paper_compresses_by_luminance() {
        // Y = 1: (1 / (1 + 1/1.5))^(1/2.2) = 0.6^(1/2.2)
        for value in paper([1.0; 3]) {
            assert_close(value, 0.792_792_730_547_422_4);
        }
        assert_eq!(paper([-1.0, 0.0, -0.5]), [0.0; 3]);
        // Y = 0.6: (2 / 1.4)^(1/2.2) > 1 stays above 1, because the metric needs it.
        assert!(paper([2.0, 0.0, 0.0])[0] > 1.0);
    }

    #[test]
    fn shown_values_stay_within_the_screen() {
        for curve in [ToneCurve::Srgb, ToneCurve::Paper] {
            assert_eq!(curve.apply([f64::INFINITY; 3]), [1.0; 3]);
            assert_eq!(curve.apply([-3.0; 3]), [0.0; 3]);
        }
    }
}
