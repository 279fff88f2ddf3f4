//! PNG files with 8 bits per channel.

use std::io;
use std::path::Path;

use super::canvas::{Canvas, Format, encode_image_as_png};
use super::{Image, ToneCurve};
use crate::Result;

/// Writes `image`, scaled by `2^exposure_stops` and shown through `curve`, to a PNG file.
pub fn write(path: &Path, image: &Image, curve: ToneCurve, exposure_stops: f32) -> Result<()> {
    let canvas = Canvas::new(Format::Png, [image.width, image.height], curve, exposure_stops);
    canvas.write(path, &image.pixels, &mut |_| {})
}

/// Writes like [`write`], but to any writer.
///
/// # Errors
/// Where the writer fails, or the image has no pixels.
pub fn encode(writer: impl io::Write, image: &Image, curve: ToneCurve, exposure_stops: f32) -> io::Result<()> {
    encode_image_as_png(writer, image, curve, exposure_stops)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(values: &[f32]) -> Image {
        Image { width: values.len() as u32, height: 1, pixels: values.iter().map(|&value| [value; 3]).collect() }
    }

    fn levels(values: &[f32], curve: ToneCurve, exposure_stops: f32) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(&mut bytes, &gray(values), curve, exposure_stops).unwrap();
        let read = ::image::load_from_memory(&bytes).unwrap().into_rgb8();
        read.pixels().map(|pixel| pixel.0[1]).collect()
    }

    #[test]
    fn rounds_to_the_nearest_level() {
        // 255 * srgb(0.5) = 187.52, 255 * srgb(0.2140) = 127.48..., 255 * 12.92 * 0.001 = 3.29
        assert_eq!(levels(&[0.0, 0.001, 0.214, 0.5, 1.0, 7.0], ToneCurve::Srgb, 0.0), [0, 3, 127, 188, 255, 255]);
        // 255 * 0.6^(1/2.2) = 202.16
        assert_eq!(levels(&[1.0], ToneCurve::Paper, 0.0), [202]);
    }

    #[test]
    fn exposure_is_in_stops() {
        assert_eq!(levels(&[0.125], ToneCurve::Srgb, 2.0), levels(&[0.5], ToneCurve::Srgb, 0.0));
        assert_eq!(levels(&[2.0], ToneCurve::Paper, -1.0), levels(&[1.0], ToneCurve::Paper, 0.0));
    }

    #[test]
    fn no_number_is_black_and_infinity_white() {
        assert_eq!(levels(&[f32::NAN, f32::INFINITY], ToneCurve::Srgb, 0.0), [0, 255]);
        assert_eq!(levels(&[f32::NAN, f32::INFINITY], ToneCurve::Paper, 0.0), [0, 255]);
    }

    #[test]
    fn the_file_holds_the_levels() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let image = Image { width: 2, height: 1, pixels: vec![[1.0, 0.0, 0.5], [0.0, 1.0, 0.0]] };
        write(&path, &image, ToneCurve::Srgb, 0.0).unwrap();
        let read = ::image::open(&path).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (2, 1));
        assert_eq!(read.into_raw(), [255, 0, 188, 0, 255, 0]);
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing/a.png");
        assert!(write(&path, &gray(&[1.0]), ToneCurve::Srgb, 0.0).is_err());
        assert!(!path.exists());
    }
}
