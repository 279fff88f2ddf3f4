//! Pictures of where a picture is wrong.

use crate::image::{Image, tone};

/// Displayed difference that is shown brightest.
const LARGEST: f64 = 0.25;
/// From none to the largest: black, purple, red, yellow, white, in linear sRGB.
const RAMP: [[f64; 3]; 5] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [0.7, 0.05, 0.02], [1.0, 0.6, 0.05], [1.0, 1.0, 1.0]];

/// The absolute difference of what is displayed, averaged over channels, in false colors from 0 (black) to 0.25 (white).
pub fn error_map(image: &Image, reference: &Image) -> Image {
    let difference = |(a, b): (&[f32; 3], &[f32; 3])| {
        let [a, b] = [a, b].map(|pixel| tone::paper(pixel.map(f64::from)));
        (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f64>() / 3.0
    };
    let pixels = image.pixels.iter().zip(&reference.pixels).map(difference);
    Image { width: image.width, height: image.height, pixels: pixels.map(|d| false_color(d / LARGEST)).collect() }
}

/// A color of the ramp; beyond 1 its last one.
pub fn false_color(value: f64) -> [f32; 3] {
    let at = value.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let lower = (at as usize).min(RAMP.len() - 2);
    let share = at - lower as f64;
    std::array::from_fn(|c| (RAMP[lower][c] * (1.0 - share) + RAMP[lower + 1][c] * share) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pixels_are_black_and_large_differences_white() {
        let image = |pixels: &[f32]| Image { width: 2, height: 1, pixels: pixels.iter().map(|&p| [p; 3]).collect() };
        let map = error_map(&image(&[0.5, 1.0]), &image(&[0.5, 0.0]));
        assert_eq!(map.pixels, [[0.0; 3], [1.0; 3]]);
        assert_eq!(false_color(0.5), [0.7, 0.05, 0.02]);
    }
}
