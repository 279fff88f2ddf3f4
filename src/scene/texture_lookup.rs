//! Textures looked up in double precision: the color at given coordinates of a surface. GLSL:
//! `glsl/include/texture/textures.glsl` and `texture_lookup.glsl`.

use glam::{DVec2, DVec3, DVec4};

use super::texture::{Image, Pattern, TexelFilter, Texels, Texture, WrapMode};
use crate::math::srgb::linear_from_srgb;

/// Linear color and alpha of a texture where the surface's coordinates are `uv`; `images` are those of the scene.
pub fn sample(texture: &Texture, images: &[Image], uv: DVec2) -> DVec4 {
    let at = (texture.to_uv.as_dmat3() * uv.extend(1.0)).truncate();
    match &texture.pattern {
        &Pattern::Checkerboard { color0, color1 } => {
            let second = |coordinate: f64| coordinate.rem_euclid(1.0) > 0.5;
            let color = if second(at.x) == second(at.y) { color0 } else { color1 };
            color.as_dvec3().extend(1.0)
        }
        // Kernels alone compute programs. Nothing that is looked up here may be one.
        Pattern::Program(program) => program.mean.as_dvec3().extend(1.0),
        &Pattern::Bitmap { image, filter: TexelFilter::Nearest, wrap } => {
            let image = &images[image as usize];
            let [column, row] =
                [(at.x, image.width), (at.y, image.height)].map(|(t, size)| (t * f64::from(size)).floor());
            decoded(image, texel(image, wrap, column as i64, row as i64))
        }
        &Pattern::Bitmap { image, filter: TexelFilter::Bilinear, wrap } => {
            let (taps, fraction) = bilinear_taps(&images[image as usize], wrap, at);
            mix(taps, fraction)
        }
        &Pattern::Bitmap { image, filter: TexelFilter::Encoded, wrap } => encoded(&images[image as usize], wrap, at),
    }
}

/// Linear color and alpha at a point of an image whose bytes are mixed before they are decoded. Each counts by its alpha.
fn encoded(image: &Image, wrap: WrapMode, at: DVec2) -> DVec4 {
    if !matches!(image.texels, Texels::Bytes { srgb: true, .. }) {
        let (taps, fraction) = bilinear_taps(image, wrap, at);
        return mix(taps, fraction);
    }
    let (taps, fraction) = stored_taps(image, wrap, at);
    let mixed = mix(taps.map(|tap| (tap.truncate() * tap.w).extend(tap.w)), fraction);
    let color = if mixed.w > 0.0 { mixed.truncate() / mixed.w } else { DVec3::ZERO };
    decoded(image, color.extend(mixed.w))
}

/// Mix of four values, row by row, by the weights of the right and of the lower ones.
fn mix(taps: [DVec4; 4], fraction: DVec2) -> DVec4 {
    let row = |i: usize| taps[i].lerp(taps[i + 1], fraction.x);
    row(0).lerp(row(2), fraction.y)
}

/// Linear color and alpha of the four texels around a point of an image, whose sides are 1, row by row; and the weights in
/// [0, 1) of the right and of the lower ones.
pub fn bilinear_taps(image: &Image, wrap: WrapMode, at: DVec2) -> ([DVec4; 4], DVec2) {
    let (taps, fraction) = stored_taps(image, wrap, at);
    (taps.map(|tap| decoded(image, tap)), fraction)
}

fn stored_taps(image: &Image, wrap: WrapMode, at: DVec2) -> ([DVec4; 4], DVec2) {
    let position = at * DVec2::new(f64::from(image.width), f64::from(image.height)) - 0.5;
    let low = position.floor();
    let tap = |column: i64, row: i64| texel(image, wrap, low.x as i64 + column, low.y as i64 + row);
    ([tap(0, 0), tap(1, 0), tap(0, 1), tap(1, 1)], position - low)
}

/// Numbers of the texel of any column and row, inside the image or beyond, as they are stored. Those of bytes are in [0, 1].
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
        Texels::Heights(data) => DVec3::splat(f64::from(data[index])).extend(1.0),
        Texels::Bytes { data, .. } => DVec4::from_array(data[index].map(|byte| f64::from(byte) / 255.0)),
    }
}

/// Linear color and alpha of stored numbers.
fn decoded(image: &Image, stored: DVec4) -> DVec4 {
    match image.texels {
        Texels::Bytes { srgb: true, .. } => {
            DVec3::from_array(stored.truncate().to_array().map(linear_from_srgb)).extend(stored.w)
        }
        _ => stored,
    }
}
