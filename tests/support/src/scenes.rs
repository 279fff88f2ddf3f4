//! The project's own scenes, and changes to them.

use lodestar::scene::{Bsdf, LoadOptions, Material, MaterialKind, Scene, SurfaceMaterial, load};
use lodestar::settings::{Learner, SamplePattern, Sampler, Settings};

use crate::scenes_folder;

/// Samplers for tests of a property that does not depend on how a guide is followed: a plain path tracer and one with a
/// guide.
pub const SAMPLERS: [Sampler; 2] = [Sampler::Bsdf, Sampler::RejectionMix];

/// The scene file `name` of `scenes/`.
pub fn ours(name: &str, defines: &[(&str, &str)]) -> Scene {
    let path = scenes_folder().join(name);
    let defines = defines.iter().map(|&(name, value)| (name.into(), value.into())).collect();
    load(&path, &LoadOptions { defines, ..LoadOptions::default() }).expect("a scene")
}

/// Settings of the scene, with the given size, sampler and seed, and without emitter sampling.
pub fn settings(scene: &Scene, [width, height]: [u32; 2], sampler: Sampler, seed: u32) -> Settings {
    steady(Settings {
        width,
        height,
        sampler,
        seed,
        nee: false,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(scene)
    })
}

/// Settings with the sampler's own defaults. For inversion, half of the samples are uniform. Where a table misses light, the few
/// other samples that find it have weights that multiply along the path. Sums of a test's size are then far from normally
/// distributed: with a share of 1/16, 64 samples per pixel of the furnace are five standard errors too dark, and 2048
/// are right. Quadtrees get the learner that they need.
pub fn steady(settings: Settings) -> Settings {
    let inverts = matches!(settings.sampler, Sampler::SphereInversion | Sampler::HemisphereInversion);
    let learner = if settings.sampler == Sampler::Quadtree { Learner::MonteCarlo } else { settings.learner };
    let min_uniform = if inverts { settings.sampler.default_min_uniform() } else { settings.min_uniform };
    Settings { min_uniform, learner, ..settings }
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

/// Surface of a material of the project's scenes.
pub fn surface_mut(material: &mut Material) -> &mut SurfaceMaterial {
    match &mut material.kind {
        MaterialKind::Surface(surface) => surface,
        _ => panic!("{} is no surface", material.name),
    }
}
