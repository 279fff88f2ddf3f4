//! `glsl/include/texture/textures.glsl` and `texture_lookup.glsl`

use glam::{DMat3, DVec2, DVec3, DVec4};

use crate::scene::texture::{Image, Pattern, TexelFilter, Texels, Texture, WrapMode};

/// Linear color and alpha where the surface's coordinates are `uv`.
pub fn sample(texture: &Texture, images: &[Image], uv: DVec2) -> DVec4 {
    let at = (to_uv(texture) * uv.extend(1.0)).truncate();
    match texture.pattern {
        Pattern::Checkerboard { color0, color1 } => {
            let second = |coordinate: f64| coordinate.rem_euclid(1.0) > 0.5;
            let color = if second(at.x) == second(at.y) { color0 } else { color1 };
            color.as_dvec3().extend(1.0)
        }
        Pattern::Bitmap { image, filter: TexelFilter::Nearest, wrap } => {
            let image = &images[image as usize];
            let [column, row] =
                [(at.x, image.width), (at.y, image.height)].map(|(t, size)| (t * f64::from(size)).floor());
            texel(image, wrap, column as i64, row as i64)
        }
        Pattern::Bitmap { image, filter: TexelFilter::Bilinear, wrap } => {
            let (taps, fraction) = taps(&images[image as usize], wrap, at);
            let row = |i: usize| taps[i].lerp(taps[i + 1], fraction.x);
            row(0).lerp(row(2), fraction.y)
        }
    }
}

/// How the luminance of the bilinear interpolation changes with the surface's coordinates, as Mitsuba has it. Zero for a
/// checkerboard and for nearest texels.
pub fn gradient(texture: &Texture, images: &[Image], uv: DVec2) -> DVec2 {
    let Pattern::Bitmap { image, filter: TexelFilter::Bilinear, wrap } = texture.pattern else { return DVec2::ZERO };
    let matrix = to_uv(texture);
    let image = &images[image as usize];
    let (taps, fraction) = taps(image, wrap, (matrix * uv.extend(1.0)).truncate());
    let [a, b, c, d] = taps.map(|tap| tap.truncate().dot(DVec3::new(0.212671, 0.715160, 0.072169)));
    let lerp = |from: f64, to: f64, t: f64| from + (to - from) * t;
    let slope = DVec2::new(lerp(b - a, d - c, fraction.y), lerp(c - a, d - b, fraction.x));
    let turned = DVec2::new(matrix.x_axis.truncate().dot(slope), matrix.y_axis.truncate().dot(slope));
    turned * DVec2::new(f64::from(image.width), f64::from(image.height))
}

fn to_uv(texture: &Texture) -> DMat3 {
    texture.to_uv.as_dmat3()
}

/// The four texels around a point, row by row, and the weights of the right and of the lower ones.
fn taps(image: &Image, wrap: WrapMode, at: DVec2) -> ([DVec4; 4], DVec2) {
    let position = at * DVec2::new(f64::from(image.width), f64::from(image.height)) - 0.5;
    let low = position.floor();
    let tap = |column: i64, row: i64| texel(image, wrap, low.x as i64 + column, low.y as i64 + row);
    ([tap(0, 0), tap(1, 0), tap(0, 1), tap(1, 1)], position - low)
}

/// The texel of any column and row, inside the image or beyond.
fn texel(image: &Image, wrap: WrapMode, column: i64, row: i64) -> DVec4 {
    let inside = |index: i64, size: u32| {
        let size = i64::from(size);
        match wrap {
            WrapMode::Repeat => index.rem_euclid(size),
            WrapMode::Clamp => index.clamp(0, size - 1),
            WrapMode::Mirror => {
                let period = index.rem_euclid(2 * size);
                period.min(2 * size - 1 - period)
            }
        }
    };
    let index = inside(row, image.height) as usize * image.width as usize + inside(column, image.width) as usize;
    match &image.texels {
        Texels::Floats(data) => DVec4::from_array(data[index].map(f64::from)),
        Texels::Bytes { srgb, data } => {
            let encoded = DVec4::from_array(data[index].map(|byte| f64::from(byte) / 255.0));
            let color = if *srgb {
                DVec3::from_array(encoded.truncate().to_array().map(decode_srgb))
            } else {
                encoded.truncate()
            };
            color.extend(encoded.w)
        }
    }
}

/// The inverse of the sRGB curve (IEC 61966-2-1).
pub fn decode_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
