//! Completion of the records of materials with a specular and a diffuse lobe: how often each is sampled, and plastics'
//! constants; and tables of words of plastics and sheens.

use std::collections::HashMap;

use glam::Vec3;

use super::materials::scalar_mut;
use crate::encode::plastic_layer::{RoughLayer, fresnel_diffuse_reflectance};
use crate::encode::sheen;
use crate::generated::constants::{
    FACETS_ALPHA_V, PHONG_SPECULAR_SAMPLING, PLASTIC_INTERNAL_REFLECTANCE, PLASTIC_SPECULAR_SAMPLING,
    ROUGH_PLASTIC_TABLE, WARD_SPECULAR_SAMPLING,
};
use crate::generated::layout::MaterialRecord;
use crate::math::microfacet::Microfacets;
use crate::scene::bsdf::{Bsdf, Distribution, Material, MaterialKind};
use crate::scene::{Scene, Textured};

/// Completes the records of a scene's materials. Returns the words of the tables, whose addresses start at 0.
pub(crate) fn complete(scene: &Scene, records: &mut [MaterialRecord]) -> Vec<u32> {
    let mut tables = Tables::default();
    for (material, record) in scene.materials.iter().zip(records) {
        complete_record(scene, material, record, &mut tables);
    }
    tables.words
}

fn complete_record(scene: &Scene, material: &Material, record: &mut MaterialRecord, tables: &mut Tables) {
    let MaterialKind::Surface(surface) = &material.kind else { return };
    if surface.sheen.is_some() {
        record.coating_specular[0] = tables.of_sheen() as f32;
    }
    let mut set = |parameter, value| *scalar_mut(record, parameter) = value;
    match &surface.bsdf {
        Bsdf::Plastic { eta, diffuse_reflectance, specular_reflectance, .. } => {
            set(PLASTIC_INTERNAL_REFLECTANCE, fresnel_diffuse_reflectance(1.0 / f64::from(*eta)) as f32);
            set(PLASTIC_SPECULAR_SAMPLING, specular_sampling(scene, specular_reflectance, diffuse_reflectance));
        }
        Bsdf::RoughPlastic { distribution, alpha, eta, diffuse_reflectance, specular_reflectance, .. } => {
            let table = tables.of(*distribution, *alpha, *eta);
            set(FACETS_ALPHA_V, *alpha);
            set(PLASTIC_INTERNAL_REFLECTANCE, table.internal_reflectance);
            set(PLASTIC_SPECULAR_SAMPLING, specular_sampling(scene, specular_reflectance, diffuse_reflectance));
            // The address is exact as a float: tables come first in their buffer, so it is far below 2^24.
            set(ROUGH_PLASTIC_TABLE, table.address as f32);
        }
        Bsdf::PolarizedPlastic { eta, diffuse_reflectance, specular_reflectance, .. } => {
            // Nothing is sent back to the base: (1 - internal reflectance) eta^2 = 1.
            set(PLASTIC_INTERNAL_REFLECTANCE, 1.0 - 1.0 / (eta * eta));
            set(PLASTIC_SPECULAR_SAMPLING, specular_sampling(scene, specular_reflectance, diffuse_reflectance));
        }
        Bsdf::Phong { diffuse_reflectance, specular_reflectance, .. } => {
            set(PHONG_SPECULAR_SAMPLING, specular_sampling(scene, specular_reflectance, diffuse_reflectance));
        }
        Bsdf::Ward { diffuse_reflectance, specular_reflectance, .. } => {
            set(WARD_SPECULAR_SAMPLING, specular_sampling(scene, specular_reflectance, diffuse_reflectance));
        }
        _ => {}
    }
}

/// Tables made so far; equal layers share one, and so do all sheens.
#[derive(Default)]
struct Tables {
    words: Vec<u32>,
    sheen: Option<u32>,
    known: HashMap<(bool, u32, u32), Table>,
}

#[derive(Clone, Copy)]
struct Table {
    address: u32,
    internal_reflectance: f32,
}

impl Tables {
    fn of(&mut self, distribution: Distribution, alpha: f32, eta: f32) -> Table {
        let is_ggx = distribution == Distribution::Ggx;
        let words = &mut self.words;
        let add = || {
            let layer = RoughLayer::new(&Microfacets::new([f64::from(alpha); 2], is_ggx), f64::from(eta));
            let address = words.len() as u32;
            words.extend(layer.words());
            Table { address, internal_reflectance: layer.internal_reflectance as f32 }
        };
        *self.known.entry((is_ggx, alpha.to_bits(), eta.to_bits())).or_insert_with(add)
    }

    /// Address of the table of sheens.
    fn of_sheen(&mut self) -> u32 {
        let words = &mut self.words;
        *self.sheen.get_or_insert_with(|| {
            let address = words.len() as u32;
            words.extend(sheen::words());
            address
        })
    }
}

/// Mean albedo of the specular lobe as a share of both lobes' mean albedo.
fn specular_sampling(scene: &Scene, specular: &Textured<Vec3>, diffuse: &Textured<Vec3>) -> f32 {
    let (specular, diffuse) = (mean(scene, specular), mean(scene, diffuse));
    if specular + diffuse > 0.0 { specular / (specular + diffuse) } else { 0.0 }
}

fn mean(scene: &Scene, textured: &Textured<Vec3>) -> f32 {
    let factor = textured.texture.map_or(Vec3::ONE, |texture| scene.textures[texture as usize].mean(&scene.images));
    (textured.value * factor).element_sum() / 3.0
}
