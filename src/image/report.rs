//! Report of a comparison: one HTML page that needs no other file and no network.
//!
//! The page holds the pictures as half floats, compressed and in base 64. A script in the page, `report/page.html`, shows them and
//! computes the error maps, except for FLIP, whose maps the page holds with 8 bits.

use std::io::{self, Write};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;
use serde::Serialize;

use super::comparison::Comparison;
use super::exr::LARGEST_HALF;
use super::{Image, ToneCurve};
use crate::files::write_whole;
use crate::{Error, Result};

/// The page. [`DATA`] stands in the place of its data, and [`TONE`] in that of the tone curves.
const PAGE: &str = include_str!("report/page.html");
const DATA: &str = "@DATA@";
const TONE: &str = "@TONE@";

/// A picture of the report.
pub struct ReportPicture {
    /// Name that the page shows.
    pub name: String,
    /// The picture itself.
    pub image: Image,
    /// Errors against the reference.
    pub errors: Comparison,
    /// FLIP of every pixel.
    pub flip: Vec<f32>,
}

/// Report of pictures of one size.
pub struct Report {
    /// The pictures.
    pub pictures: Vec<ReportPicture>,
    /// Name of the reference.
    pub reference_name: String,
    /// The reference.
    pub reference: Image,
    /// Tone curve with which the page opens.
    pub tone: ToneCurve,
    /// Exposure in stops with which the page opens.
    pub exposure: f32,
}

#[derive(Serialize)]
struct PageData<'a> {
    version: &'a str,
    width: u32,
    height: u32,
    tone: ToneCurve,
    exposure: f32,
    reference: PictureData<'a>,
    pictures: Vec<PictureData<'a>>,
}

#[derive(Serialize)]
struct PictureData<'a> {
    name: &'a str,
    pixels: String,
    flip: Option<String>,
    errors: Option<Comparison>,
}

impl Report {
    /// Writes the page, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = self.page().map_err(Error::write(path))?;
        write_whole(path, |writer| writer.write_all(text.as_bytes()))
    }

    fn page(&self) -> io::Result<String> {
        let picture = |picture: &'_ ReportPicture| -> io::Result<(String, String)> {
            Ok((packed_pixels(&picture.image)?, packed(&picture.flip.iter().map(|&e| level(e)).collect::<Vec<_>>())?))
        };
        let packed_pictures = self.pictures.iter().map(picture).collect::<io::Result<Vec<_>>>()?;
        let pictures = self.pictures.iter().zip(packed_pictures).map(|(picture, (pixels, flip))| PictureData {
            name: &picture.name,
            pixels,
            flip: Some(flip),
            errors: Some(picture.errors),
        });
        let data = PageData {
            version: env!("CARGO_PKG_VERSION"),
            width: self.reference.width,
            height: self.reference.height,
            tone: self.tone,
            exposure: self.exposure,
            reference: PictureData {
                name: &self.reference_name,
                pixels: packed_pixels(&self.reference)?,
                flip: None,
                errors: None,
            },
            pictures: pictures.collect(),
        };
        // A name with `</script>` must not end the script.
        let json = serde_json::to_string(&data)?.replace('<', "\\u003c");
        // The page has one script, which imports nothing.
        let curves = include_str!("tone.js").replace("export ", "");
        Ok(PAGE.replacen(TONE, &curves, 1).replacen(DATA, &json, 1))
    }
}

/// Nearest of 256 levels of a value in [0, 1].
fn level(value: f32) -> u8 {
    (255.0 * value).round() as u8
}

/// Pixels as half floats: first the upper bytes of all values, then the lower bytes, because alike bytes compress better.
fn packed_pixels(image: &Image) -> io::Result<String> {
    let values = image.pixels.as_flattened();
    let halves: Vec<_> =
        values.iter().map(|&value| f16::from_f32(value.clamp(-LARGEST_HALF, LARGEST_HALF)).to_bits()).collect();
    let upper = halves.iter().map(|half| (half >> 8) as u8);
    let lower = halves.iter().map(|half| (half & 0xff) as u8);
    packed(&upper.chain(lower).collect::<Vec<_>>())
}

/// Bytes in zlib's format, in base 64.
fn packed(bytes: &[u8]) -> io::Result<String> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    Ok(STANDARD.encode(encoder.finish()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::io::Read;

    fn unpacked(text: &serde_json::Value) -> Vec<u8> {
        let mut bytes = Vec::new();
        let packed = STANDARD.decode(text.as_str().unwrap()).unwrap();
        flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn the_page_holds_the_pictures_and_needs_nothing_else() {
        let image = |value: f32| Image { width: 2, height: 1, pixels: vec![[value, 0.5, 1.0e9], [0.25; 3]] };
        let (errors, flip) = Comparison::new(&image(2.0), &image(1.0)).unwrap();
        let name = "a</script><b>.exr".to_owned();
        let report = Report {
            pictures: vec![ReportPicture { name: name.clone(), image: image(2.0), errors, flip: flip.clone() }],
            reference_name: "ref.exr".into(),
            reference: image(1.0),
            tone: ToneCurve::Paper,
            exposure: 1.5,
        };
        let page = report.page().unwrap();
        assert_eq!(page.matches("</script>").count(), PAGE.matches("</script>").count());
        for outside in ["http:", "https:", "src=\"", "@import", "url("] {
            assert!(!page.contains(outside), "{outside}");
        }
        let line = page.lines().find_map(|line| line.strip_prefix("const DATA = ")).unwrap();
        let data: serde_json::Value = serde_json::from_str(line.strip_suffix(';').unwrap()).unwrap();
        assert_eq!((&data["tone"], &data["exposure"]), (&"paper".into(), &1.5.into()));
        assert_eq!(data["pictures"][0]["name"], name);
        assert_eq!(data["pictures"][0]["errors"]["mae"], errors.metrics.mae);
        assert_eq!(unpacked(&data["pictures"][0]["flip"]), flip.iter().map(|&e| level(e)).collect::<Vec<_>>());
        let bytes = unpacked(&data["pictures"][0]["pixels"]);
        let half = |at: usize| f16::from_bits(u16::from_be_bytes([bytes[at], bytes[at + 6]])).to_f32();
        assert_eq!([0, 1, 2, 3].map(half), [2.0, 0.5, LARGEST_HALF, 0.25]);
    }
}
