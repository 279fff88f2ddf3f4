//! Images of floating-point numbers as halves (IEEE 754 binary16), two to a word.

use half::f16;

/// Exponent of the limit to which an image's largest value is scaled. Halves reach 65504; a large scale keeps the most
/// digits of small values.
const LARGEST_EXPONENT: f32 = 15.0;

/// Factor by which the halves of these values must be multiplied. It is a power of two, so an image of halves stays
/// exact.
pub fn scale(values: impl Iterator<Item = f32>) -> f32 {
    let largest = values.fold(0.0f32, |largest, value| largest.max(value.abs()));
    // The limit keeps the power of two a normal number for any image.
    (largest.max(f32::MIN_POSITIVE).log2().ceil() - LARGEST_EXPONENT).max(-100.0).exp2()
}

/// Words of a texel: red and green in the first, blue and alpha in the second.
pub fn words(texel: [f32; 4], scale: f32) -> [u32; 2] {
    let [red, green, blue, alpha] = texel.map(|value| u32::from(f16::from_f32(value / scale).to_bits()));
    [red | green << 16, blue | alpha << 16]
}

/// Writes the words of several texels.
pub(super) fn write(target: &mut [u32], texels: &[[f32; 4]], scale: f32) {
    for (pair, texel) in target.chunks_exact_mut(2).zip(texels) {
        pair.copy_from_slice(&words(*texel, scale));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn there_and_back(texel: [f32; 4]) -> [f32; 4] {
        let scale = scale(texel.into_iter());
        let words = words(texel, scale);
        let half = |bits: u32| scale * f16::from_bits(bits as u16).to_f32();
        [half(words[0]), half(words[0] >> 16), half(words[1]), half(words[1] >> 16)]
    }

    #[test]
    fn halves_stay_as_they_are() {
        for texel in [[1.0, 0.5, 0.099_975_586, 0.0], [65504.0, 1.0, 3.0, -2.0], [6.0e-8, 0.0, 6.0e-8, 0.0]] {
            let texel = texel.map(|value| f16::from_f32(value).to_f32());
            assert_eq!(there_and_back(texel), texel);
        }
    }

    #[test]
    fn any_range_fits() {
        for largest in [3.0e38, 1.0e9, 1.0, 1.0e-9, 0.0] {
            let texel = [largest, -largest, 0.3 * largest, 0.001 * largest];
            for (value, expected) in there_and_back(texel).into_iter().zip(texel) {
                assert!((value - expected).abs() <= 5.0e-4 * expected.abs(), "{value} is not {expected}");
            }
        }
    }
}
