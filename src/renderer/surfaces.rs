//! A scene's materials and textures as the kernels read them.

use super::{materials, plastics};
use crate::layout::MaterialRecord;
use crate::scene::Scene;
use crate::textures::PackedTextures;

const TEXEL_BYTES: usize = 16;

/// What surfaces are made of.
pub(super) struct Surfaces {
    pub materials: Vec<MaterialRecord>,
    pub textures: PackedTextures,
}

impl Surfaces {
    pub fn new(scene: &Scene) -> Self {
        let mut materials: Vec<_> = scene.materials.iter().map(materials::record).collect();
        let tables = plastics::complete(scene, &mut materials);
        Self { materials, textures: PackedTextures::new(&scene.textures, &scene.images, tables) }
    }

    /// Texels of the largest buffer.
    pub fn texels(&self) -> u64 {
        self.textures.longest().max((size_of_val(&self.materials[..]) / TEXEL_BYTES) as u64)
    }
}
