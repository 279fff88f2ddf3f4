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
    /// Troy Sobotka's AgX in Benjamin Wrensch's minimal form, near to Blender's.
    Agx,
    /// John Hable's filmic curve.
    Filmic,
    /// The Academy's reference transforms in Stephen Hill's fit.
    Aces,
}

impl ToneCurve {
    /// Display values in [0, 1] of a linear color.
    pub fn apply(self, color: [f64; 3]) -> [f64; 3] {
        let shown = match self {
            Self::Srgb => color.map(srgb),
            Self::Paper => paper(color),
            Self::Agx => agx(color),
            Self::Filmic => filmic(color),
            Self::Aces => aces(color),
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

/// Product of a matrix, row by row, and a color.
fn product(matrix: &[[f64; 3]; 3], color: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * color[0] + row[1] * color[1] + row[2] * color[2])
}

/// Color without negative values, NaN and infinity.
fn bounded(color: [f64; 3]) -> [f64; 3] {
    color.map(|value| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1e6) })
}

/// AgX, the display transform of Troy Sobotka (<https://github.com/sobotka/AgX>), in the minimal form of Benjamin Wrensch
/// (<https://iolite-engine.com/blog_posts/minimal_agx_implementation>): a matrix, logarithms, a polynomial of degree 6 for the sigmoid, and
/// the matrix back. The values are ready for the display. The polynomial's mean squared error is 3.7e-6, whose root is half a level of 8 bits.
/// Blender's AgX takes another way, through Rec. 2020 with tables for the gamut, so that saturated colors differ.
fn agx(color: [f64; 3]) -> [f64; 3] {
    const INTO: [[f64; 3]; 3] = [
        [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
        [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
        [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
    ];
    const BACK: [[f64; 3]; 3] = [
        [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
        [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
        [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
    ];
    const SIGMOID: [f64; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
    // Stops of black and of white.
    const DARKEST: f64 = -12.473_93;
    const BRIGHTEST: f64 = 4.026_069;
    let contrast = |value: f64| {
        let share = (value.log2().clamp(DARKEST, BRIGHTEST) - DARKEST) / (BRIGHTEST - DARKEST);
        SIGMOID.into_iter().fold(0.0, |sum, factor| sum * share + factor)
    };
    product(&BACK, product(&INTO, bounded(color)).map(contrast))
}

/// The filmic curve of John Hable's *Uncharted 2: HDR Lighting* (GDC 2010), with its exposure bias of 2 and its white of 11.2, then the sRGB
/// transfer function. It is not what Blender calls Filmic.
fn filmic(color: [f64; 3]) -> [f64; 3] {
    let curve = |x: f64| (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
    bounded(color).map(|value| srgb(curve(2.0 * value) / curve(11.2)))
}

/// Stephen Hill's fit of ACES' RRT and ODT for sRGB (`ACES.hlsl` of <https://github.com/TheRealMJP/BakingLab>), then the sRGB transfer
/// function.
fn aces(color: [f64; 3]) -> [f64; 3] {
    const INTO: [[f64; 3]; 3] =
        [[0.597_19, 0.354_58, 0.048_23], [0.076, 0.908_34, 0.015_66], [0.0284, 0.133_83, 0.837_77]];
    const BACK: [[f64; 3]; 3] =
        [[1.604_75, -0.531_08, -0.073_67], [-0.102_08, 1.108_13, -0.006_05], [-0.003_27, -0.072_76, 1.076_02]];
    let fit = |v: f64| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    product(&BACK, product(&INTO, bounded(color)).map(fit)).map(|value| srgb(value.clamp(0.0, 1.0)))
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
        for &curve in <ToneCurve as VariantArray>::VARIANTS {
            let white = curve.apply([f64::INFINITY; 3]);
            assert!(white.iter().all(|&value| (0.99..=1.0).contains(&value)), "{curve:?}: {white:?}");
            assert!(
                curve.apply([-3.0, f64::NAN, 0.0]).iter().all(|&value| value < 0.002 || value.is_nan()),
                "{curve:?}"
            );
        }
        for curve in [ToneCurve::Srgb, ToneCurve::Paper] {
            assert_eq!((curve.apply([f64::INFINITY; 3]), curve.apply([-3.0; 3])), ([1.0; 3], [0.0; 3]));
        }
    }

    /// Pages show pictures by a script with the same constants.
    #[test]
    fn the_script_has_the_same_constants() {
        let ours = include_str!("tone.rs").replace('_', "");
        let is_digit = |c: char| c.is_ascii_digit() || c == '.';
        let script = include_str!("tone.js").split(|c| !is_digit(c));
        let constants: Vec<_> = script.filter(|word| word.contains('.') && word.len() > 4).collect();
        assert!(constants.len() > 40, "{constants:?}");
        for constant in constants {
            let whole = |(at, _): (usize, &str)| !ours[at + constant.len()..].starts_with(is_digit);
            assert!(ours.match_indices(constant).any(whole), "{constant} of tone.js is not in tone.rs");
        }
    }

    /// Grays become brighter with their light, and stay gray: the rows of each matrix add up to 1.
    #[test]
    fn grays_stay_gray_and_in_order() {
        for &curve in <ToneCurve as VariantArray>::VARIANTS {
            let mut before = 0.0;
            for stops in -8..5 {
                let [r, g, b] = curve.apply([2.0_f64.powi(stops); 3]);
                assert!((r - g).abs() < 1e-3 && (b - g).abs() < 1e-3 && g >= before, "{curve:?}, {stops}: {r} {g} {b}");
                before = g;
            }
        }
    }

    /// Values by hand from the published formulas.
    #[test]
    fn curves_have_their_published_values() {
        // Filmic: the white of 11.2 is 5.6 before the bias, and 0.18 becomes srgb(curve(0.36) / curve(11.2)).
        assert_close(ToneCurve::Filmic.apply([5.6; 3])[0], 1.0);
        let curve =
            |x: f64| (x * (0.15 * x + 0.1 * 0.5) + 0.2 * 0.02) / (x * (0.15 * x + 0.5) + 0.2 * 0.3) - 0.02 / 0.3;
        assert_close(ToneCurve::Filmic.apply([0.18; 3])[1], srgb(curve(0.36) / curve(11.2)));
        // ACES: grays pass both matrices nearly unchanged, so that 1 becomes the fit of 1.
        let fit = (1.024_578_6 - 0.000_090_537) / (0.983_729 + 0.432_951 + 0.238_081);
        assert!((ToneCurve::Aces.apply([1.0; 3])[2] - srgb(fit)).abs() < 1e-4);
        // AgX: middle gray is at 10.0 of 16.5 stops, where the sigmoid has about half of its range.
        let middle = ToneCurve::Agx.apply([0.18; 3])[0];
        assert!((0.44..0.52).contains(&middle), "{middle}");
        // A bright saturated color goes towards white.
        let [r, g, b] = ToneCurve::Agx.apply([16.0, 0.1, 0.1]);
        assert!(r > g && g > 0.4 && (g - b).abs() < 0.05, "{r} {g} {b}");
    }
}
