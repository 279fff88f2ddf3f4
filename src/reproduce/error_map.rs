//! Error maps: pictures that show where a picture differs from its reference.

use crate::image::false_color::false_color;
use crate::image::{Image, tone};

/// Displayed difference that gets the brightest color.
const LARGEST: f64 = 0.25;
/// Map of the absolute difference of the displayed pictures, averaged over the channels, in false colors from 0 (black)
/// to 0.25 (white).
pub fn error_map(image: &Image, reference: &Image) -> Image {
    let difference = |(a, b): (&[f32; 3], &[f32; 3])| {
        let [a, b] = [a, b].map(|pixel| tone::paper(pixel.map(f64::from)));
        (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f64>() / 3.0
    };
    let pixels = image.pixels.iter().zip(&reference.pixels).map(difference);
    Image { width: image.width, height: image.height, pixels: pixels.map(|d| false_color(d / LARGEST)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pixels_are_black_and_large_differences_white() {
        let image = |pixels: &[f32]| Image { width: 2, height: 1, pixels: pixels.iter().map(|&p| [p; 3]).collect() };
        let map = error_map(&image(&[0.5, 1.0]), &image(&[0.5, 0.0]));
        assert_eq!(map.pixels, [[0.0; 3], [1.0; 3]]);
    }
}
