//! Textures as the kernels read them (`glsl/include/texture/textures.glsl`): one record each, and the words of their
//! images, together with the tables that materials refer to. CPU only.

pub(crate) mod halves;
mod programs;
mod records;
mod words;

use std::borrow::Cow;

use crate::generated::layout::{TEXEL_BYTES, TextureRecord};
use crate::scene::texture::{Image, Texture};

use programs::Programs;
pub use words::TexelWords;

/// All textures of a scene.
#[derive(Clone)]
pub struct PackedTextures {
    /// One record per texture.
    pub records: Vec<TextureRecord>,
    /// Words that records and materials refer to.
    pub words: TexelWords,
    /// `TEXTURE_*` bits of all textures.
    pub kinds: u32,
    /// Bits `1 << OPERATION_*` of the operations of all programs.
    pub operations: u64,
}

impl PackedTextures {
    /// Packs textures, their programs and the images that they show, and grids of words. The words of `tables` come first. Returns
    /// the address of each grid, too.
    pub fn new(textures: &[Texture], images: &[Image], grids: &[Cow<[u32]>], mut tables: Vec<u32>) -> (Self, Vec<u32>) {
        let programs = Programs::append(textures, &mut tables);
        let (words, addresses) = TexelWords::new(tables, images, &records::used_images(textures, images), grids);
        let packed = Self {
            records: records::records(textures, images, &words, &programs),
            words,
            kinds: records::kinds(textures, images),
            operations: programs.operations,
        };
        (packed, addresses)
    }

    /// Number of 16-byte texels of the largest buffer.
    pub fn longest(&self) -> u64 {
        let records = size_of_val(&self.records[..]) / TEXEL_BYTES;
        self.words.longest_page().max(records) as u64
    }
}
