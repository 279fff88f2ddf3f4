//! Files of color alone, for other programs: PNG, JPEG and TIFF for screens, and Radiance HDR with linear values.

use std::io::{self, Cursor, Write};
use std::path::Path;

use ::image::codecs::hdr::HdrEncoder;
use ::image::codecs::jpeg::JpegEncoder;
use ::image::codecs::png::PngEncoder;
use ::image::codecs::tiff::TiffEncoder;
use ::image::{ExtendedColorType, ImageEncoder};

use super::{Image, ToneCurve};
use crate::Result;
use crate::files::{has_extension, write_whole};

/// Formats of color files by the endings of their names.
const ENDINGS: [(&str, Format); 6] = [
    ("png", Format::Png),
    ("jpg", Format::Jpeg),
    ("jpeg", Format::Jpeg),
    ("tif", Format::Tiff),
    ("tiff", Format::Tiff),
    ("hdr", Format::Hdr),
];
/// Quality of JPEG files, from 1 to 100.
const JPEG_QUALITY: u8 = 95;
/// Most pixels of a side of a JPEG file.
const LONGEST_JPEG: u32 = 65_535;
/// Most bytes of a TIFF file beside its pixels. Its strips have a megabyte or a row, and each takes eight bytes.
const TIFF_HEAD: u32 = 1 << 16;
/// Largest value of an HDR file. Its exponents end at 2^127.
const LARGEST_HDR: f32 = 1.0e38;

/// Format of a file of color alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// 8 bits per channel, without loss.
    Png,
    /// 8 bits per channel, with loss.
    Jpeg,
    /// 16 bits per channel, not compressed.
    Tiff,
    /// Radiance's RGBE: linear values, 8 bits per channel and a common exponent.
    Hdr,
}

impl Format {
    /// Format that the ending of a name asks for; `None` for other names, such as those of EXR files.
    pub fn of(path: &Path) -> Option<Self> {
        ENDINGS.iter().find(|(ending, _)| has_extension(path, ending)).map(|&(_, format)| format)
    }

    /// Bytes of a pixel before they are compressed.
    fn bytes_per_pixel(self) -> u64 {
        match self {
            Self::Png | Self::Jpeg => 3,
            Self::Tiff => 6,
            Self::Hdr => 12,
        }
    }

    /// Why the format cannot hold a picture of this width and height; `None` where it can.
    pub fn fault_of_size(self, [width, height]: [u32; 2]) -> Option<String> {
        let bytes = self.bytes_per_pixel().saturating_mul(u64::from(width) * u64::from(height));
        match self {
            Self::Jpeg if width.max(height) > LONGEST_JPEG => {
                Some(format!("a JPEG file has at most {LONGEST_JPEG} pixels a side"))
            }
            Self::Tiff if bytes > u64::from(u32::MAX - TIFF_HEAD) => Some("a TIFF file holds less than 4 GiB".into()),
            _ => None,
        }
    }

    /// Whether tone curve and exposure make the values, for a screen.
    pub fn is_for_screens(self) -> bool {
        self != Self::Hdr
    }
}

/// Colors of a picture in the form of a file. They come some pixels at a time.
pub struct Canvas {
    format: Format,
    size: [u32; 2],
    curve: ToneCurve,
    scale: f64,
    bytes: Vec<u8>,
}

impl Canvas {
    /// A picture of this width and height without pixels yet. For screens, colors are scaled by `2^exposure_stops` and shown through
    /// `curve`.
    pub fn new(format: Format, size: [u32; 2], curve: ToneCurve, exposure_stops: f32) -> Self {
        let bytes = Vec::with_capacity(format.bytes_per_pixel() as usize * size[0] as usize * size[1] as usize);
        Self { format, size, curve, scale: f64::from(exposure_stops).exp2(), bytes }
    }

    /// A whole image.
    pub fn of_image(format: Format, image: &Image, curve: ToneCurve, exposure_stops: f32) -> Self {
        let mut canvas = Self::new(format, [image.width, image.height], curve, exposure_stops);
        canvas.add(&image.pixels);
        canvas
    }

    /// Adds the next pixels, row by row from the top left.
    pub fn add(&mut self, pixels: &[[f32; 3]]) {
        let Self { curve, scale, .. } = *self;
        let show = |pixel: &[f32; 3]| curve.apply(pixel.map(|value| f64::from(value) * scale));
        match self.format {
            Format::Png | Format::Jpeg => {
                self.bytes.extend(pixels.iter().flat_map(|pixel| show(pixel).map(|value| level(value, 255.0) as u8)));
            }
            Format::Tiff => {
                let level = |value| (level(value, 65_535.0) as u16).to_ne_bytes();
                self.bytes.extend(pixels.iter().flat_map(|pixel| show(pixel).map(level)).flatten());
            }
            Format::Hdr => {
                // Negative values and NaN become 0.
                let bounded = |value: f32| {
                    let value: f32 = if value > 0.0 { value.min(LARGEST_HDR) } else { 0.0 };
                    value.to_ne_bytes()
                };
                self.bytes.extend(pixels.iter().flat_map(|pixel| pixel.map(bounded)).flatten());
            }
        }
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// Where the file cannot be written, or its format has not so many pixels.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_whole(path, |writer| self.encode(writer))
    }

    /// Writes like [`Canvas::write`], but to any writer.
    ///
    /// # Errors
    /// Where the writer fails, or the format has not so many pixels.
    pub fn encode(&self, mut writer: impl Write) -> io::Result<()> {
        let [width, height] = self.size;
        if let Some(fault) = self.format.fault_of_size(self.size) {
            return Err(io::Error::other(format!("{fault}; write an .exr file")));
        }
        let encoded = match self.format {
            Format::Png => PngEncoder::new(writer).write_image(&self.bytes, width, height, ExtendedColorType::Rgb8),
            Format::Jpeg => {
                let encoder = JpegEncoder::new_with_quality(writer, JPEG_QUALITY);
                encoder.write_image(&self.bytes, width, height, ExtendedColorType::Rgb8)
            }
            Format::Hdr => HdrEncoder::new(writer).write_image(&self.bytes, width, height, ExtendedColorType::Rgb32F),
            Format::Tiff => {
                // The encoder goes back to the places of numbers that it learns later.
                let mut file = Cursor::new(Vec::with_capacity(self.bytes.len() + TIFF_HEAD as usize));
                let encoded =
                    TiffEncoder::new(&mut file).write_image(&self.bytes, width, height, ExtendedColorType::Rgb16);
                return encoded.map_err(io::Error::other).and_then(|()| writer.write_all(file.get_ref()));
            }
        };
        encoded.map_err(io::Error::other)
    }
}

/// Level nearest to a value in [0, 1], of which `most` is the largest. Values outside are clamped, and NaN becomes 0.
fn level(value: f64, most: f64) -> f64 {
    (most * value).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::texels::{self, FileTexels};

    const COLORS: [[f32; 3]; 4] = [[1.0, 0.0, 0.5], [0.25, 7.0, f32::NAN], [-1.0, 0.001, f32::INFINITY], [0.2; 3]];

    fn written(name: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let image = Image { width: 2, height: 2, pixels: COLORS.to_vec() };
        Canvas::of_image(Format::of(&path).unwrap(), &image, ToneCurve::Srgb, 0.0).write(&path).unwrap();
        (folder, path)
    }

    #[test]
    fn endings_have_formats() {
        let of = |name: &str| Format::of(Path::new(name));
        assert_eq!([of("a.JPG"), of("a.jpeg")], [Some(Format::Jpeg); 2]);
        assert_eq!([of("a.tif"), of("a.Tiff")], [Some(Format::Tiff); 2]);
        assert_eq!((of("a.png"), of("a.hdr"), of("a.exr")), (Some(Format::Png), Some(Format::Hdr), None));
    }

    #[test]
    fn formats_have_limits() {
        let fits = |format: Format, size| format.fault_of_size(size).is_none();
        assert!(fits(Format::Jpeg, [65_535, 2]) && !fits(Format::Jpeg, [2, 65_536]));
        assert!(fits(Format::Tiff, [26_754, 26_754]) && !fits(Format::Tiff, [26_755, 26_755]));
        assert!(fits(Format::Png, [65_536, 65_536]) && fits(Format::Hdr, [65_536, 65_536]));
    }

    #[test]
    fn hdr_files_keep_linear_values() {
        let (_folder, path) = written("a.hdr");
        let FileTexels::Linear(texels) = texels::read(&path).unwrap().texels else { panic!("floats") };
        for (texel, color) in texels.iter().zip(COLORS) {
            let largest = color.iter().copied().filter(|value| value.is_finite()).fold(0.0, f32::max);
            for (&read, value) in texel.iter().zip(color) {
                let expected = if value > 0.0 { value.min(LARGEST_HDR) } else { 0.0 };
                let is_small = color.contains(&f32::INFINITY) && value.is_finite();
                assert!(is_small || (read - expected).abs() <= largest.max(expected) / 128.0, "{read}, {value}");
            }
        }
    }

    #[test]
    fn jpeg_files_show_the_levels_roughly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let image = Image { width: 16, height: 16, pixels: vec![[0.2, 0.5, 0.1]; 256] };
        Canvas::of_image(Format::Jpeg, &image, ToneCurve::Srgb, 0.0).write(&path).unwrap();
        let FileTexels::Bytes(texels) = texels::read(&path).unwrap().texels else { panic!("bytes") };
        // 255 * srgb(0.2) = 123.5, 255 * srgb(0.5) = 187.5, 255 * srgb(0.1) = 88.9
        for (level, expected) in texels[100].iter().zip([124, 188, 89_u8]) {
            assert!(level.abs_diff(expected) <= 3, "{level} is not {expected}");
        }
    }

    #[test]
    fn tiff_files_have_sixteen_bits() {
        let (_folder, path) = written("a.tif");
        let FileTexels::Encoded(texels) = texels::read(&path).unwrap().texels else { panic!("16 bits") };
        let levels = |at: usize| [0, 1, 2].map(|channel| (texels[at][channel] * 65_535.0).round());
        // 65535 * srgb(0.5) = 48192.1, and 65535 * srgb(0.001) = 846.7
        assert_eq!(levels(0), [65_535.0, 0.0, 48_192.0]);
        assert_eq!((levels(1)[2], levels(2)), (0.0, [0.0, 847.0, 65_535.0]));
    }
}
