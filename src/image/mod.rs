//! Pictures in memory and on disk: EXR, PNG and the error between two of them. CPU only.

pub mod canvas;
pub mod color;
pub mod columns;
pub mod comparison;
mod date;
mod exposure;
pub mod exr;
mod exr_columns;
mod exr_limits;
pub mod false_color;
pub mod flip;
mod ktx2;
pub mod layers;
pub mod metrics;
mod pfm;
pub mod png;
mod primaries;
mod radiance;
pub mod report;
pub mod texels;
pub mod tone;

pub use exposure::{Exposure, Luminances};
pub use tone::ToneCurve;

/// Pixels that are read at a time.
const PIXELS_AT_A_TIME: u32 = 1 << 18;
/// Rows whose multiples are read at a time: blocks of files and tiles of films then are read once.
const ROWS: u32 = 16;

/// Number of rows of this width that are read at a time, where memory does not hold the whole picture.
pub fn rows_at_a_time(width: u32) -> u32 {
    PIXELS_AT_A_TIME.div_ceil(width.max(1)).next_multiple_of(ROWS)
}

/// A picture in linear sRGB.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels, row by row from the top left.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// The window of `width` x `height` pixels whose top left pixel is `offset`; `None` where it does not lie within.
    pub fn crop(&self, offset: [u32; 2], width: u32, height: u32) -> Option<Self> {
        let [left, top] = offset;
        if left.checked_add(width)? > self.width || top.checked_add(height)? > self.height {
            return None;
        }
        let row = |y: u32| {
            let start = y as usize * self.width as usize + left as usize;
            &self.pixels[start..start + width as usize]
        };
        let pixels = (top..top + height).flat_map(row).copied().collect();
        Some(Self { width, height, pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_within_only() {
        let pixels = (0..12).map(|i| [i as f32; 3]).collect();
        let image = Image { width: 4, height: 3, pixels };
        let window = image.crop([1, 1], 2, 2).unwrap();
        assert_eq!(window.pixels, [[5.0; 3], [6.0; 3], [9.0; 3], [10.0; 3]]);
        assert_eq!(image.crop([3, 0], 2, 1), None);
        assert_eq!(image.crop([0, u32::MAX], 1, 1), None);
    }
}
