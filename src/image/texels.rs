//! Texture images: JPEG, PNG, WebP, TGA, BMP, TIFF, HDR, PFM, EXR and KTX2, read in the precision of the file.

use std::io::Cursor;
use std::path::Path;

use ::image::{DynamicImage, ExtendedColorType, ImageDecoder as _, ImageError, ImageFormat, ImageReader, Limits};

use super::{exr, ktx2, pfm, radiance};
use crate::{Error, Result, inputs, quoted};

/// Limit on the decoded size in bytes, because a damaged header may ask for any size.
const MAX_DECODED_BYTES: u64 = 2 << 30;
const MAX_SIDE: u32 = 1 << 16;
/// Limit on the file's size in bytes: no image within [`MAX_DECODED_BYTES`] takes more on the disk.
const MAX_FILE_BYTES: u64 = 2 << 30;

const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// An image in memory, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelImage {
    /// Width in texels, > 0.
    pub width: u32,
    /// Height in texels, > 0.
    pub height: u32,
    /// `width * height` texels, row by row.
    pub texels: FileTexels,
    /// Matrix, row by row, that takes the file's colors to linear sRGB; `None` where they are that. Numbers, such as normals, are not colors.
    pub to_srgb: Option<[[f32; 3]; 3]>,
}

impl TexelImage {
    /// The image with its colors in linear sRGB.
    pub fn in_srgb(mut self) -> Self {
        if let (Some(matrix), FileTexels::Linear(texels)) = (self.to_srgb.take(), &mut self.texels) {
            for texel in texels {
                let [red, green, blue, alpha] = *texel;
                let [red, green, blue] = exr::transformed(&matrix, [red, green, blue]);
                *texel = [red, green, blue, alpha];
            }
        }
        self
    }
}

/// Texels as red, green, blue and alpha. Gray stands in all three color channels.
#[derive(Debug, Clone, PartialEq)]
pub enum FileTexels {
    /// Texels of a file with at most 8 bits per channel.
    Bytes(Vec<[u8; 4]>),
    /// Texels of a file with 16 bits per channel, in [0, 1], with the transfer curve of 8-bit files.
    Encoded(Vec<[f32; 4]>),
    /// Texels of a file of floating-point numbers: linear, any value.
    Linear(Vec<[f32; 4]>),
}

/// Reads the image at `path`. The format is recognized by the content, or else by the file name.
///
/// # Errors
/// [`Error::Image`] where the file is cut short, decodes to more than 2 GiB or has an unsupported format;
/// [`Error::Read`] where it cannot be read.
pub fn read(path: &Path) -> Result<TexelImage> {
    decode(path, &inputs::read(path, MAX_FILE_BYTES)?)
}

/// Reads an image in memory. `path` is its name, for messages.
///
/// # Errors
/// [`Error::Image`] as in [`read`].
pub fn decode(path: &Path, bytes: &[u8]) -> Result<TexelImage> {
    if bytes.starts_with(&EXR_MAGIC) {
        let (image, to_srgb) = exr::decode_rgb(path, bytes)?;
        return Ok(TexelImage { to_srgb, ..of_floats(image) });
    }
    if pfm::is_pfm(bytes) {
        return Ok(of_floats(pfm::decode(path, bytes)?));
    }
    if ktx2::is_ktx2(bytes) {
        let (width, height, texels) = ktx2::decode(path, bytes, MAX_SIDE, MAX_DECODED_BYTES)?;
        return Ok(TexelImage { width, height, texels: FileTexels::Bytes(texels), to_srgb: None });
    }
    let bytes = &radiance::usual(bytes)[..];
    let format = ::image::guess_format(bytes).or_else(|_| ImageFormat::from_path(path));
    let format = format.ok().filter(ImageFormat::reading_enabled).ok_or_else(|| {
        let what = match ::image::guess_format(bytes) {
            Ok(format) => format!("images of the format {} are not read", format!("{format:?}").to_uppercase()),
            Err(_) => "its image format is not supported".to_owned(),
        };
        Error::image(path, format!("{what}; save it as JPEG, PNG, WebP, TGA, BMP, TIFF, HDR, PFM, EXR or KTX2"))
    })?;
    if format == ImageFormat::Jpeg && !is_whole_jpeg(bytes) {
        return Err(Error::image(path, "the JPEG image is cut short; write it again"));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    reader.limits(limits);
    let image = reader.decode().map_err(|error| decode_error(path, &error))?;
    convert(path, image)
}

/// Number of channels of a PNG, a JPEG or another of the usual images; `None` where its header is not known.
pub fn channels(bytes: &[u8]) -> Option<u8> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?;
    Some(reader.into_decoder().ok()?.color_type().channel_count())
}

fn of_floats(image: super::Image) -> TexelImage {
    let texels = image.pixels.into_iter().map(|[red, green, blue]| [red, green, blue, 1.0]).collect();
    TexelImage { width: image.width, height: image.height, texels: FileTexels::Linear(texels), to_srgb: None }
}

fn decode_error(path: &Path, error: &ImageError) -> Error {
    let message = quoted::message(error);
    match error {
        ImageError::Limits(_) => {
            Error::image(path, "it is larger than 65536 texels a side or 2 GiB; save a smaller one")
        }
        ImageError::Unsupported(_) => Error::image(path, format!("it is of a kind that is not supported ({message})")),
        _ => Error::image(path, format!("it is not a whole image ({message}); write it again")),
    }
}

fn convert(path: &Path, image: DynamicImage) -> Result<TexelImage> {
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return Err(Error::image(path, "it has no pixels"));
    }
    let texels = match &image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => FileTexels::Linear(floats(image)),
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => FileTexels::Encoded(floats(image)),
        _ => {
            FileTexels::Bytes(image.into_rgba8().into_raw().chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect())
        }
    };
    Ok(TexelImage { width, height, texels, to_srgb: None })
}

fn floats(image: DynamicImage) -> Vec<[f32; 4]> {
    image.into_rgba32f().into_raw().chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect()
}

/// Whether the end marker (ITU T.81, B.1.1.3) follows the last segment. The decoder itself would fill missing data with
/// gray.
fn is_whole_jpeg(bytes: &[u8]) -> bool {
    const END: u8 = 0xd9;
    const START: u8 = 0xd8;
    let mut at = 0;
    while let Some(offset) = bytes[at..].iter().position(|&byte| byte == 0xff) {
        at += offset + 1;
        match bytes.get(at) {
            None => return false,
            Some(&END) => return true,
            // Stuffing, or a marker without a segment. Below, 0xff is a fill byte: the marker follows it.
            Some(&(0x00 | 0x01 | START | 0xd0..=0xd7)) => at += 1,
            Some(0xff) => {}
            Some(_) => match bytes.get(at + 1..at + 3) {
                Some(length) => at += 1 + usize::from(u16::from_be_bytes([length[0], length[1]])),
                None => return false,
            },
        }
        if at >= bytes.len() {
            return false;
        }
    }
    false
}

/// PNG file of an image that few renderers read: WebP, KTX2, or a TIFF of whole numbers. `None` for any other.
///
/// # Errors
/// [`Error::Image`] as in [`read`].
pub fn common(path: &Path, bytes: &[u8]) -> Result<Option<Vec<u8>>> {
    let of_rare_format = |format| matches!(format, ImageFormat::WebP | ImageFormat::Tiff);
    let is_rare = ktx2::is_ktx2(bytes) || ::image::guess_format(bytes).is_ok_and(of_rare_format);
    if !is_rare {
        return Ok(None);
    }
    match decode(path, bytes)? {
        TexelImage { width, height, texels: FileTexels::Bytes(texels), .. } => {
            encode_png(path, width, height, &texels).map(Some)
        }
        TexelImage { width, height, texels: FileTexels::Encoded(texels), .. } => {
            let levels = texels.as_flattened().iter().map(|value| (value * 65_535.0).round() as u16);
            let bytes: Vec<u8> = levels.flat_map(u16::to_ne_bytes).collect();
            png_of(path, width, height, &bytes, ExtendedColorType::Rgba16).map(Some)
        }
        TexelImage { texels: FileTexels::Linear(_), .. } => Ok(None),
    }
}

/// PNG file of texels with 8 bits a channel.
///
/// # Errors
/// [`Error::Image`] where the encoder fails.
pub fn encode_png(name: &Path, width: u32, height: u32, texels: &[[u8; 4]]) -> Result<Vec<u8>> {
    png_of(name, width, height, texels.as_flattened(), ExtendedColorType::Rgba8)
}

fn png_of(name: &Path, width: u32, height: u32, texels: &[u8], form: ExtendedColorType) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    ::image::write_buffer_with_format(&mut bytes, texels, width, height, form, ImageFormat::Png)
        .map_err(|error| Error::image(name, error.to_string()))?;
    Ok(bytes.into_inner())
}
