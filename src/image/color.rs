//! Colors of pictures of any format, for what shows and compares them.

use std::path::Path;

use super::texels::{self, FileTexels};
use super::{Image, exr};
use crate::Result;
use crate::files::has_extension;
use crate::math::srgb::linear_from_srgb;

/// Reads the color of a picture in linear sRGB. The text says what the file does not hold, where that is so: a file of 8 or 16 bits has no
/// values above 1.
///
/// # Errors
/// Where the file cannot be read, or its format is not known.
pub fn read(path: &Path) -> Result<(Image, Option<String>)> {
    if has_extension(path, "exr") {
        return Ok((exr::read_rgb(path)?, None));
    }
    let image = texels::read(path)?.in_srgb();
    let linear = |value: f32| linear_from_srgb(value.into()) as f32;
    let (pixels, bits) = match image.texels {
        FileTexels::Bytes(texels) => {
            let levels: Vec<f32> = (0..=u8::MAX).map(|level| linear(f32::from(level) / 255.0)).collect();
            let pixel = |[r, g, b, _]: [u8; 4]| [r, g, b].map(|level| levels[usize::from(level)]);
            (texels.into_iter().map(pixel).collect(), Some(8))
        }
        FileTexels::Encoded(texels) => {
            (texels.into_iter().map(|[r, g, b, _]| [r, g, b].map(linear)).collect(), Some(16))
        }
        FileTexels::Linear(texels) => (texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(), None),
    };
    let note = bits.map(|bits| {
        format!("{}: {bits} bits per channel, taken as sRGB and made linear; nothing is above 1", path.display())
    });
    Ok((Image { width: image.width, height: image.height, pixels }, note))
}

#[test]
fn pictures_of_8_bits_become_linear() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let image = Image { width: 2, height: 1, pixels: vec![[0.5, 0.0, 1.0], [7.0, 0.214, 0.2]] };
    super::png::write(&path, &image, super::ToneCurve::Srgb, 0.0).unwrap();
    let (read, note) = read(&path).unwrap();
    for (read, value) in read.pixels.as_flattened().iter().zip(image.pixels.as_flattened()) {
        assert!((read - value.min(1.0)).abs() < 0.005, "{read} is not {value}");
    }
    assert!(note.unwrap().contains("8 bits per channel"));
}
