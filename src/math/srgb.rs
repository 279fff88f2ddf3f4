//! The sRGB curve (IEC 61966-2-1).

/// Linear value in [0, 1] of an encoded value in [0, 1]: the inverse of [`srgb`](crate::image::tone::srgb).
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
