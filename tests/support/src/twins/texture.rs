//! Twin of the gradients in `glsl/include/texture/textures.glsl`. Look-ups are in [`lodestar::scene::texture_lookup`].

use glam::{DVec2, DVec3};
use lodestar::scene::texture::{Image, Pattern, TexelFilter, Texture};
use lodestar::scene::texture_lookup::bilinear_taps;

/// Gradient of the luminance of the bilinear interpolation, in the surface's coordinates, as in Mitsuba. It is zero for
/// a checkerboard and for nearest texels.
pub fn gradient(texture: &Texture, images: &[Image], uv: DVec2) -> DVec2 {
    let Pattern::Bitmap { image, filter: TexelFilter::Bilinear, wrap } = texture.pattern else { return DVec2::ZERO };
    let matrix = texture.to_uv.as_dmat3();
    let image = &images[image as usize];
    let (taps, fraction) = bilinear_taps(image, wrap, (matrix * uv.extend(1.0)).truncate());
    let [a, b, c, d] = taps.map(|tap| tap.truncate().dot(DVec3::new(0.212671, 0.715160, 0.072169)));
    let lerp = |from: f64, to: f64, t: f64| from + (to - from) * t;
    let slope = DVec2::new(lerp(b - a, d - c, fraction.y), lerp(c - a, d - b, fraction.x));
    let turned = DVec2::new(matrix.x_axis.truncate().dot(slope), matrix.y_axis.truncate().dot(slope));
    turned * DVec2::new(f64::from(image.width), f64::from(image.height))
}
