//! The sRGB curve and the luminance of colors (IEC 61966-2-1).

/// Luminances of red, green and blue of sRGB. GLSL: `glsl/include/math/constants.glsl`.
const LUMINANCE: [f64; 3] = [0.212671, 0.715160, 0.072169];

/// Luminance of a linear color.
pub fn luminance(color: [f64; 3]) -> f64 {
    color.iter().zip(LUMINANCE).map(|(channel, weight)| channel * weight).sum()
}

/// Linear value in [0, 1] of an encoded value in [0, 1]: the inverse of [`srgb`](crate::image::tone::srgb).
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
