//! Records of textures: `TextureRecord`.

use super::halves;
use super::programs::Programs;
use super::words::TexelWords;
use crate::generated::constants;
use crate::generated::layout::TextureRecord;
use crate::scene::texture::{Image, Pattern, TexelFilter, Texels, Texture, WrapMode};

/// Whether a texture shows each image; the other images belong to an environment.
pub(super) fn used_images(textures: &[Texture], images: &[Image]) -> Vec<bool> {
    let mut used = vec![false; images.len()];
    for texture in textures {
        if let Pattern::Bitmap { image, .. } = texture.pattern {
            used[image as usize] = true;
        }
    }
    used
}

/// `TEXTURE_*` bits of all textures.
pub(super) fn kinds(textures: &[Texture], images: &[Image]) -> u32 {
    textures.iter().fold(0, |bits, texture| bits | kind(texture, images))
}

/// Records of all textures.
pub(super) fn records(
    textures: &[Texture],
    images: &[Image],
    words: &TexelWords,
    programs: &Programs,
) -> Vec<TextureRecord> {
    textures.iter().enumerate().map(|(at, texture)| record(texture, images, words, programs.addresses[at])).collect()
}

/// Record of a texture. `program` is the address of its program, if it has one.
fn record(texture: &Texture, images: &[Image], words: &TexelWords, program: u32) -> TextureRecord {
    let [u, v, w] = texture.to_uv.to_cols_array_2d();
    let plain = TextureRecord {
        kind: kind(texture, images),
        // A checkerboard needs a size too, because kernels fetch it with the rest of the record.
        size: [1; 2],
        u_row: [u[0], v[0], w[0]],
        v_row: [u[1], v[1], w[1]],
        scale: 1.0,
        ..bytemuck::Zeroable::zeroed()
    };
    match &texture.pattern {
        &Pattern::Bitmap { image, .. } => {
            let address = words.address(image).unwrap_or(0);
            let image = &images[image as usize];
            let scale = match &image.texels {
                Texels::Bytes { .. } | Texels::Heights(_) => 1.0,
                Texels::Floats(data) => halves::scale(data.iter().flatten().copied()),
            };
            TextureRecord { address, size: [image.width, image.height], scale, ..plain }
        }
        Pattern::Checkerboard { color0, color1 } => {
            TextureRecord { colors: [color0, color1].map(|color| color.extend(1.0).into()), ..plain }
        }
        Pattern::Program(found) => TextureRecord {
            address: program,
            size: [found.instructions.len() as u32, u32::from(found.reads_position())],
            colors: found.limits.map(|limit| [limit; 4]),
            ..plain
        },
    }
}

fn kind(texture: &Texture, images: &[Image]) -> u32 {
    let transformed = if texture.to_uv == glam::Mat3::IDENTITY { 0 } else { constants::TEXTURE_TRANSFORMED };
    transformed
        | match texture.pattern {
            Pattern::Bitmap { image, filter, wrap } => {
                texel_kind(&images[image as usize], filter) | filter_kind(filter) | wrap_kind(wrap)
            }
            Pattern::Checkerboard { .. } => constants::TEXTURE_CHECKERBOARD,
            Pattern::Program(_) => constants::TEXTURE_PROGRAM,
        }
}

fn texel_kind(image: &Image, filter: TexelFilter) -> u32 {
    match image.texels {
        // Texels are fetched as they are, and their mix is decoded.
        Texels::Bytes { srgb: true, .. } if filter == TexelFilter::Encoded => {
            constants::TEXTURE_LINEAR_BYTES | constants::TEXTURE_ENCODED
        }
        Texels::Bytes { srgb: true, .. } => constants::TEXTURE_SRGB_BYTES,
        Texels::Bytes { srgb: false, .. } => constants::TEXTURE_LINEAR_BYTES,
        Texels::Floats(_) => constants::TEXTURE_HALVES,
        Texels::Heights(_) => constants::TEXTURE_HEIGHTS,
    }
}

fn filter_kind(filter: TexelFilter) -> u32 {
    match filter {
        TexelFilter::Bilinear | TexelFilter::Encoded => constants::TEXTURE_BILINEAR,
        TexelFilter::Nearest => constants::TEXTURE_NEAREST,
    }
}

fn wrap_kind(wrap: WrapMode) -> u32 {
    match wrap {
        WrapMode::Repeat => constants::TEXTURE_REPEAT,
        WrapMode::Mirror => constants::TEXTURE_MIRROR,
        WrapMode::Clamp => constants::TEXTURE_CLAMP,
    }
}
