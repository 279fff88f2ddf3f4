//! The project's own scenes, and changes to them.

use std::path::Path;

use lodestar::scene::{Bsdf, LoadOptions, Material, MaterialKind, Scene, SurfaceMaterial, load};
use lodestar::settings::{Sampler, Settings};

/// Both samplers.
pub const SAMPLERS: [Sampler; 2] = [Sampler::Bsdf, Sampler::RejectionMix];

/// The scene file `name` of `scenes/`.
pub fn ours(name: &str, defines: &[(&str, &str)]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let defines = defines.iter().map(|&(name, value)| (name.into(), value.into())).collect();
    load(&path, &LoadOptions { defines }).expect("a scene")
}

/// The scene's own settings but for the size, sampler and seed.
pub fn settings(scene: &Scene, [width, height]: [u32; 2], sampler: Sampler, seed: u32) -> Settings {
    Settings { width, height, sampler, seed, ..Settings::for_scene(scene) }
}

/// The scene with every albedo multiplied.
pub fn with_albedo_scaled(scene: &Scene, factor: f32) -> Scene {
    let mut scene = scene.clone();
    for material in &mut scene.materials {
        if let Bsdf::Diffuse { reflectance } = &mut surface_mut(material).bsdf {
            reflectance.value *= factor;
        }
    }
    scene
}

/// The surface that a material of the project's scenes is.
pub fn surface_mut(material: &mut Material) -> &mut SurfaceMaterial {
    match &mut material.kind {
        MaterialKind::Surface(surface) => surface,
        _ => panic!("{} is no surface", material.name),
    }
}
