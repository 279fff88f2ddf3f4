//! Brightness of a textured emitter on a primitive.

use glam::{DVec2, Vec2, Vec3, dvec2};

use crate::generated::constants;
use crate::generated::layout::{AttributeRecord, PrimitiveRecord};
use crate::scene::texture_lookup::sample;
use crate::scene::{Image, Texture};

/// Number of look-ups for all primitives together, and the least and most for one primitive.
const POINTS: usize = 1 << 20;
const POINTS_OF_PRIMITIVE: [usize; 2] = [16, 1 << 14];
/// Share of its brightest texel that is added to a texture's mean, so that an emitter with small bright parts can be
/// drawn.
const BRIGHTEST_SHARE: f64 = 1.0 / 1024.0;

/// Number of points at which a texture is looked up on each of `primitive_count` primitives.
pub(super) fn points_for(primitive_count: usize) -> usize {
    let [least, most] = POINTS_OF_PRIMITIVE;
    (POINTS / primitive_count.max(1)).clamp(least, most)
}

/// Mean of the texture's red, green and blue over the primitive, plus [`BRIGHTEST_SHARE`] of the `brightest` texel of the whole
/// texture.
pub(super) fn brightness(
    texture: &Texture,
    images: &[Image],
    brightest: Vec3,
    primitive: &PrimitiveRecord,
    attributes: &AttributeRecord,
    points: usize,
) -> f64 {
    let color = |i: usize| sample(texture, images, coordinates(primitive, attributes, even_point(i))).truncate();
    let mean = (0..points).map(|i| color(i).element_sum()).sum::<f64>() / points as f64;
    (mean + BRIGHTEST_SHARE * f64::from(brightest.element_sum())) / 3.0
}

/// Points that fill the unit square evenly (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
fn even_point(i: usize) -> DVec2 {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    (0.5 + (i + 1) as f64 * dvec2(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC))).fract()
}

/// Texture coordinates of a point on the primitive. For `u` uniform on the unit square, the point is uniform in area.
fn coordinates(primitive: &PrimitiveRecord, attributes: &AttributeRecord, u: DVec2) -> DVec2 {
    match primitive.flags & constants::PRIMITIVE_SHAPE_MASK {
        constants::SHAPE_TRIANGLE => {
            let [a, b, c] = [attributes.uv0, attributes.uv1, attributes.uv2].map(|uv| Vec2::from(uv).as_dvec2());
            let root = u.x.sqrt();
            a + (1.0 - root) * (b - a) + root * u.y * (c - a)
        }
        constants::SHAPE_PARALLELOGRAM => u,
        constants::SHAPE_DISK => dvec2(u.x.sqrt(), u.y),
        _ => dvec2(u.x, (1.0 - 2.0 * u.y).acos() / std::f64::consts::PI),
    }
}

#[cfg(test)]
mod tests {
    use glam::Mat3;

    use super::*;
    use crate::scene::texture::Pattern;

    fn checkerboard() -> Texture {
        let pattern = Pattern::Checkerboard { color0: Vec3::ZERO, color1: Vec3::ONE };
        Texture { name: String::new(), pattern, to_uv: Mat3::IDENTITY }
    }

    fn triangle(uvs: [[f32; 2]; 3]) -> f64 {
        let [uv0, uv1, uv2] = uvs;
        let attributes = AttributeRecord { uv0, uv1, uv2, ..bytemuck::Zeroable::zeroed() };
        let primitive = PrimitiveRecord { flags: constants::SHAPE_TRIANGLE, ..bytemuck::Zeroable::zeroed() };
        brightness(&checkerboard(), &[], Vec3::ONE, &primitive, &attributes, 4096)
    }

    #[test]
    fn a_part_is_as_bright_as_it_is_there() {
        let dark = triangle([[0.1, 0.1], [0.4, 0.1], [0.1, 0.4]]);
        let bright = triangle([[0.6, 0.1], [0.9, 0.1], [0.6, 0.4]]);
        let all = triangle([[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]]);
        assert!(dark == BRIGHTEST_SHARE && bright == 1.0 + BRIGHTEST_SHARE && (all - 0.5).abs() < 0.02, "{all}");
    }

    #[test]
    fn other_shapes_show_the_whole_texture() {
        for flags in [constants::SHAPE_PARALLELOGRAM, constants::SHAPE_SPHERE] {
            let primitive = PrimitiveRecord { flags, ..bytemuck::Zeroable::zeroed() };
            let found = brightness(&checkerboard(), &[], Vec3::ONE, &primitive, &bytemuck::Zeroable::zeroed(), 4096);
            assert!((found - 0.5).abs() < 0.01, "{found}");
        }
        // The inner half of the radius covers a quarter of a disk.
        let primitive = PrimitiveRecord { flags: constants::SHAPE_DISK, ..bytemuck::Zeroable::zeroed() };
        let texture = Texture { to_uv: Mat3::from_scale(glam::vec2(1.0, 0.0)), ..checkerboard() };
        let found = brightness(&texture, &[], Vec3::ONE, &primitive, &bytemuck::Zeroable::zeroed(), 4096);
        assert!((found - 0.75).abs() < 0.01, "{found}");
    }
}
