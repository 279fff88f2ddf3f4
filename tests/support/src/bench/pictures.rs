//! Pictures for the documents, as small JPEG files.

use std::path::{Path, PathBuf};

use image::ExtendedColorType::Rgb8;
use image::codecs::jpeg::JpegEncoder;
use lodestar::image::{Image, ToneCurve};

const QUALITY: u8 = 70;

/// Folder for a bench's files, which `LODESTAR_OUT` names; `None` if nobody asked for files.
pub fn out_folder() -> Option<PathBuf> {
    let folder = std::env::var_os("LODESTAR_OUT").map(PathBuf::from)?;
    std::fs::create_dir_all(&folder).expect("the folder LODESTAR_OUT");
    Some(folder)
}

/// File name of a method: `product, emitters sampled` becomes `product-emitters-sampled`.
pub fn file_name(method: &str) -> String {
    let words = method.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

/// Writes a picture by the sRGB curve.
pub fn write_jpeg(path: &Path, picture: &Image) {
    let shown = picture.pixels.iter().flat_map(|pixel| ToneCurve::Srgb.apply(pixel.map(f64::from)));
    let bytes: Vec<u8> = shown.map(|value| (255.0 * value).round() as u8).collect();
    let mut file = Vec::new();
    let encoded = JpegEncoder::new_with_quality(&mut file, QUALITY).encode(&bytes, picture.width, picture.height, Rgb8);
    encoded.expect("a JPEG picture");
    std::fs::write(path, file).expect("a picture's file");
    println!("wrote {}", path.display());
}
