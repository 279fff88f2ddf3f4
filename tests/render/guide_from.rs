//! Renders that begin with the guide of another render.

use lodestar::Result;
use lodestar::renderer::Renderer;
use lodestar::renderer::guide_tables::GuideTables;
use lodestar::scene::Scene;
use lodestar::settings::{Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::mutated::DENSITIES_FAR;
use support::scenes::{ours, settings, steady};

use crate::device::{Device, steps};

/// Whether a render that `begin` gives a guide agrees with an unguided one.
fn agrees_with(
    unguided: &Estimate,
    device: &Device,
    scene: &Scene,
    settings: &Settings,
    begin: impl Fn(&mut Renderer) -> Result<()>,
) -> bool {
    let mut renderer = device.renderer(scene, settings);
    begin(&mut renderer).expect("a guide that fits");
    steps(&mut renderer, settings, 512);
    let picture = Estimate::of(&renderer.picture().expect("a picture"));
    let comparison = Comparison::new(unguided, &picture, &[8, WHOLE]);
    println!("{}: {comparison:?}", device.mutation());
    comparison.agrees()
}

/// Settings of a small picture whose emitters are sampled.
fn sampled(scene: &Scene, sampler: Sampler, seed: u32) -> Settings {
    steady(Settings { nee: true, max_depth: 8, ..settings(scene, [16, 16], sampler, seed) })
}

/// A picture that begins with a guide agrees with an unguided one. Densities that are 25 % off are found.
#[test]
fn a_picture_that_begins_with_a_guide_is_unbiased() {
    let scene = ours("cornell-box/scene.xml", &[]);
    let with = |sampler, seed| steady(settings(&scene, [16, 16], sampler, seed));
    let device = Device::new();
    let unguided = Estimate::of(&device.render(&scene, &with(Sampler::Bsdf, 1), 1024));
    let mut teacher = device.renderer(&scene, &with(Sampler::RejectionMix, 2));
    steps(&mut teacher, &with(Sampler::RejectionMix, 2), 64);
    let guide = teacher.learned_guide().expect("a guide");

    // Another seed, and later samples of the teacher's seed.
    let later = Settings { sample_offset: Some(64), ..with(Sampler::RejectionMix, 2) };
    let begin = |renderer: &mut Renderer| renderer.begin_with_guide(&guide);
    let agrees = |device: &Device, settings: &Settings| agrees_with(&unguided, device, &scene, settings, begin);
    assert!(agrees(&device, &with(Sampler::RejectionMix, 3)));
    assert!(agrees(&device, &later));
    assert!(!agrees(&device.mutated(DENSITIES_FAR), &with(Sampler::RejectionMix, 3)));
}

/// A guide of another scene has other cells, and other lights or another number of groups of lights. The picture stays unbiased.
#[test]
fn a_guide_of_another_scene_is_unbiased() {
    let scene = ours("cornell-box/scene.xml", &[]);
    let device = Device::new();
    let unguided = Estimate::of(&device.render(&scene, &sampled(&scene, Sampler::Bsdf, 1), 1024));
    for other in [ours("lights/scene.xml", &[]), ours("lights/floor.xml", &[("light", "constant")])] {
        let mut teacher = device.renderer(&other, &sampled(&other, Sampler::Product, 2));
        steps(&mut teacher, &sampled(&other, Sampler::Product, 2), 16);
        let guide = teacher.learned_guide().expect("a guide");
        let begin = |renderer: &mut Renderer| renderer.begin_with_guide(&guide);
        let agrees =
            |device: &Device| agrees_with(&unguided, device, &scene, &sampled(&scene, Sampler::Product, 3), begin);
        assert!(agrees(&device) && !agrees(&device.mutated(DENSITIES_FAR)));
    }
}

/// Guides as files hold them, of two seeds and merged, begin renders of a scene whose lamp has moved since. The picture stays unbiased.
#[test]
fn a_guide_of_a_file_is_unbiased_after_a_lamp_has_moved() {
    let scene = ours("cornell-box/scene.xml", &[]);
    let mut before = scene.clone();
    // The lamp is where the emitting primitives are.
    let moved = glam::Vec3::new(-0.3, 0.0, 0.2);
    before.primitives.iter_mut().filter(|primitive| primitive.emitter.is_some()).for_each(|lamp| lamp.origin += moved);
    let device = Device::new();
    let unguided = Estimate::of(&device.render(&scene, &sampled(&scene, Sampler::Bsdf, 1), 1024));
    for sampler in [Sampler::Product, Sampler::RejectionMix] {
        let taught = |seed| {
            let settings = sampled(&before, sampler, seed);
            let mut teacher = device.renderer(&before, &settings);
            steps(&mut teacher, &settings, 16);
            teacher.guide_tables().expect("a guide")
        };
        let tables = GuideTables::merged(vec![taught(2), taught(4)]).expect("a guide");
        let begin = |renderer: &mut Renderer| renderer.begin_with_tables(tables.clone());
        let agrees = |device: &Device| agrees_with(&unguided, device, &scene, &sampled(&scene, sampler, 3), begin);
        assert!(agrees(&device) && !agrees(&device.mutated(DENSITIES_FAR)));
    }
}
