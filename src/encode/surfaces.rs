//! A scene's materials, textures and lights as kernels read them.

use super::lights::Lights;
use super::textures::PackedTextures;
use super::{materials, measured, plastics, volumes};
use crate::generated::layout::{MaterialRecord, TEXEL_BYTES, VolumeRecord};
use crate::scene::Scene;

/// Materials and textures. They do not depend on the hierarchy, so both can be made ready at the same time.
#[derive(Clone)]
pub struct Surfaces {
    pub(crate) materials: Vec<MaterialRecord>,
    /// Volumes of the media. They follow the materials.
    pub(crate) volumes: Vec<VolumeRecord>,
    pub(crate) textures: PackedTextures,
}

impl Surfaces {
    /// Tabulates a scene's materials and packs its textures.
    pub fn new(scene: &Scene) -> Self {
        let mut materials: Vec<_> = materials::records(scene);
        let tables = plastics::complete(scene, &mut materials);
        let (mut volumes, mut grids) = volumes::records(&scene.media);
        let measured = measured::complete(scene, &mut materials, &mut grids);
        let (textures, addresses) = PackedTextures::new(&scene.textures, &scene.images, &grids, tables);
        volumes::set_addresses(&mut volumes, &addresses);
        measured::set_addresses(&mut materials, &measured, &addresses);
        Self { materials, volumes, textures }
    }

    /// Bytes of the buffer of materials.
    pub(crate) fn material_bytes(&self) -> Vec<u8> {
        [bytemuck::cast_slice(&self.materials), bytemuck::cast_slice(&self.volumes)].concat()
    }
}

/// Surfaces and the lights that shine on them.
pub(crate) struct Shading {
    pub surfaces: Surfaces,
    pub lights: Lights,
}

impl Shading {
    /// Texels of the largest buffer.
    pub fn texels(&self) -> u64 {
        let Surfaces { materials, volumes, textures } = &self.surfaces;
        let materials = (size_of_val(&materials[..]) + size_of_val(&volumes[..])) as u64 / TEXEL_BYTES as u64;
        materials.max(textures.longest()).max(self.lights.texel_count() as u64)
    }

    /// Bytes of all buffers.
    pub fn bytes(&self) -> u64 {
        let Surfaces { materials, volumes, textures } = &self.surfaces;
        let words: usize = textures.words.pages().iter().map(|page| size_of_val(&page[..])).sum();
        let records = size_of_val(&textures.records[..]) + size_of_val(&materials[..]) + size_of_val(&volumes[..]);
        (words + records + self.lights.texel_count() * size_of::<[u32; 4]>()) as u64
    }
}
