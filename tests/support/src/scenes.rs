//! The project's own scenes, and changes to them.

use lodestar::scene::{Bsdf, LoadOptions, Material, MaterialKind, Scene, SurfaceMaterial, load};
use lodestar::settings::{
    AUTO_GRID, BsdfShare, DirectionMap, GuideSet, Learner, Mix, Roulette, SamplePattern, Sampler, Settings,
};

use crate::{scenes_folder, tier};

/// Samplers for tests of a property that does not depend on how a guide is followed: a plain path tracer and one with a
/// guide.
pub const SAMPLERS: [Sampler; 2] = [Sampler::Bsdf, Sampler::RejectionMix];

pub const ALL_SAMPLERS: [Sampler; 7] = [
    Sampler::Bsdf,
    Sampler::RejectionMix,
    Sampler::Rejection,
    Sampler::SphereInversion,
    Sampler::HemisphereInversion,
    Sampler::Product,
    Sampler::Quadtree,
];

/// All samplers that follow a guide, each with every learner that it can be combined with. The quick tier has every
/// sampler with its default learner, and one sampler with every learner.
pub fn combinations() -> impl Iterator<Item = (Sampler, Learner)> {
    let learners = [Learner::Sarsa, Learner::ExpectedSarsa, Learner::MonteCarlo];
    let all = ALL_SAMPLERS[1..].iter().flat_map(move |&sampler| learners.map(|learner| (sampler, learner)));
    all.filter(|&(sampler, learner)| sampler != Sampler::Quadtree || learner == Learner::MonteCarlo).filter(
        |&(sampler, learner)| {
            tier::is_full() || sampler == Sampler::RejectionMix || learner == sampler.default_learner()
        },
    )
}

/// Change of the settings that a test makes.
pub type Change = fn(&mut Settings);

/// All ways to follow a guide, by name.
pub const GUIDED: [(&str, Change); 18] = [
    ("rejection-mix", |s| s.sampler = Sampler::RejectionMix),
    ("rejection-mix of acceptances", |s| (s.sampler, s.mix) = (Sampler::RejectionMix, Mix::Acceptance)),
    ("rejection-mix at e = 0.5", |s| (s.sampler, s.epsilon) = (Sampler::RejectionMix, Some(0.5))),
    ("rejection-mix on the cylinder", |s| (s.sampler, s.map) = (Sampler::RejectionMix, DirectionMap::Cylindrical)),
    ("rejection", |s| s.sampler = Sampler::Rejection),
    ("sphere-inversion", |s| s.sampler = Sampler::SphereInversion),
    ("hemisphere-inversion", |s| s.sampler = Sampler::HemisphereInversion),
    ("hemisphere-inversion on the cylinder", |s| {
        (s.sampler, s.map) = (Sampler::HemisphereInversion, DirectionMap::Cylindrical);
    }),
    ("product", |s| s.sampler = Sampler::Product),
    ("product on the cylinder", |s| (s.sampler, s.map) = (Sampler::Product, DirectionMap::Cylindrical)),
    ("product with a fixed share and roulette by throughput", |s| {
        (s.sampler, s.bsdf_share) = (Sampler::Product, Some(BsdfShare::Fixed));
        s.roulette = Some(Roulette::Throughput);
    }),
    ("product on all rough surfaces", |s| (s.sampler, s.guide_set) = (Sampler::Product, GuideSet::All)),
    ("product in cells that fall back on their parents", |s| {
        (s.sampler, s.grid, s.fallback) = (Sampler::Product, Some(AUTO_GRID), Some(4.0));
    }),
    ("rejection-mix in such cells", |s| {
        (s.sampler, s.grid, s.fallback) = (Sampler::RejectionMix, Some(13), Some(16.0));
    }),
    ("quadtree", |s| (s.sampler, s.learner) = (Sampler::Quadtree, Learner::MonteCarlo)),
    ("quadtree on the cylinder", |s| {
        (s.sampler, s.learner, s.map) = (Sampler::Quadtree, Learner::MonteCarlo, DirectionMap::Cylindrical);
    }),
    ("expected-sarsa", |s| (s.sampler, s.learner) = (Sampler::RejectionMix, Learner::ExpectedSarsa)),
    ("monte-carlo", |s| (s.sampler, s.learner) = (Sampler::RejectionMix, Learner::MonteCarlo)),
];

/// Ways to follow a guide of this run: all of them in the long tier; in the quick tier one of each kind.
pub fn guided() -> Vec<(&'static str, Change)> {
    const FEW: [&str; 4] =
        ["rejection-mix", "hemisphere-inversion", "product in cells that fall back on their parents", "quadtree"];
    GUIDED.into_iter().filter(|(name, _)| tier::is_full() || FEW.contains(name)).collect()
}

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
