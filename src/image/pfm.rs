//! Portable float maps: linear pictures of 32-bit floats, as pbrt's environments often are.

use std::path::Path;

use super::Image;
use crate::{Error, Result};

/// Most pixels, 16384 x 16384, because a damaged header may ask for any size.
const MAX_PIXEL_COUNT: u64 = 1 << 28;

/// Whether the bytes begin as a portable float map does: `PF` with colors, or `Pf` in gray.
pub(super) fn is_pfm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace())
}

/// Picture of a portable float map. `path` is its name, for messages.
pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<Image> {
    let fault = |message: &str| Error::image(path, format!("it is not a whole PFM image ({message}); write it again"));
    let is_color = bytes.get(1) == Some(&b'F');
    let mut at = 2;
    let mut word = || {
        let is_space = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_whitespace);
        while is_space(at) {
            at += 1;
        }
        let begin = at;
        while at < bytes.len() && !is_space(at) {
            at += 1;
        }
        std::str::from_utf8(bytes.get(begin..at)?).ok()
    };
    let mut side = || word().and_then(|word| word.parse::<u32>().ok()).filter(|&side| side > 0);
    let (Some(width), Some(height)) = (side(), side()) else { return Err(fault("its header gives no size")) };
    let scale = word().and_then(|word| word.parse::<f32>().ok()).filter(|scale| scale.is_finite() && *scale != 0.0);
    let scale = scale.ok_or_else(|| fault("its header gives no scale and byte order"))?;
    if u64::from(width) * u64::from(height) > MAX_PIXEL_COUNT {
        return Err(Error::image(path, "it is larger than 2^28 pixels; crop it"));
    }
    let (width_texels, channels) = (width as usize, if is_color { 3 } else { 1 });
    // One byte of white space ends the header.
    let (floats, _) = bytes.get(at + 1..).unwrap_or_default().as_chunks::<4>();
    let floats = floats.get(..width_texels * height as usize * channels).ok_or_else(|| fault("it is cut short"))?;
    let number = |bytes: [u8; 4]| if scale < 0.0 { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) };
    // As in Mitsuba and pbrt, the sign is the byte order and the magnitude is a factor.
    let float = |bytes: [u8; 4]| number(bytes) * scale.abs();
    let pixel = |pixel: &[[u8; 4]]| match pixel {
        [red, green, blue] => [*red, *green, *blue].map(float),
        other => [float(other[0]); 3],
    };
    // Rows run from the bottom.
    let rows = floats.chunks_exact(width_texels * channels).rev();
    let pixels = rows.flat_map(|row| row.chunks_exact(channels).map(pixel)).collect();
    Ok(Image { width, height, pixels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_and_both_kinds() {
        let bytes = |header: &str, floats: &[[u8; 4]]| [header.as_bytes(), floats.as_flattened()].concat();
        let color = bytes("PF\n1 2\n-1.0\n", &[1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0].map(f32::to_le_bytes));
        let image = decode(Path::new("a.pfm"), &color).unwrap();
        assert_eq!((image.width, image.height, image.pixels), (1, 2, vec![[4.0, 5.0, 6.0], [1.0, 2.0, 3.0]]));
        let gray = bytes("Pf 2 1 1\n", &[0.5f32, 8.0].map(f32::to_be_bytes));
        assert!(is_pfm(&color) && is_pfm(&gray));
        let scaled = bytes("Pf 2 1 -2.5\n", &[0.5f32, 8.0].map(f32::to_le_bytes));
        assert_eq!(decode(Path::new("a.pfm"), &scaled).unwrap().pixels, [[1.25; 3], [20.0; 3]]);
        for scale in ["0", "-0.0", "nan", "inf"] {
            let error = decode(Path::new("a.pfm"), &bytes(&format!("Pf 1 1 {scale}\n"), &[[0; 4]])).unwrap_err();
            assert!(error.to_string().contains("no scale and byte order"), "{error}");
        }
        assert_eq!(decode(Path::new("a.pfm"), &gray).unwrap().pixels, [[0.5; 3], [8.0; 3]]);
        for length in 0..color.len() {
            assert!(decode(Path::new("a.pfm"), &color[..length]).is_err());
        }
        let error = decode(Path::new("a.pfm"), &color[..20]).unwrap_err().to_string();
        assert_eq!(error, "a.pfm: it is not a whole PFM image (it is cut short); write it again");
    }
}
