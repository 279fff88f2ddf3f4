//! Learning of the guide, and limits of the estimator.

use std::cell::Cell;

use glam::{Vec3, vec3};
use lodestar::Error;
use lodestar::scene::bsdf::{Bsdf, Distribution, Microfacets};
use lodestar::scene::texture::Textured;
use lodestar::scene::{Environment, ReconstructionFilter, Scene};
use lodestar::settings::{GuideSet, Sampler, Settings};
use support::estimate::Estimate;
use support::rows::combinations;
use support::scenes::{SAMPLERS, ours, settings, surface_mut};
use support::significance::{ALPHA, sidak, two_sided};

use crate::device::{Device, steps};

/// Guided rays find the light more often with every step, as in the paper's Fig. 7a.
#[test]
fn guided_rays_find_the_light_more_often_step_by_step() {
    let device = Device::validated();
    let scene = ours("cornell-box-hard/scene.xml", &[]);
    let rates = |sampler| {
        let settings = settings(&scene, [128, 128], sampler, 1);
        let rates = steps(&mut device.renderer(&scene, &settings), &settings, 48);
        let rates: Vec<f64> = rates.iter().map(|counts| counts.light_hit_rate()).collect();
        println!("{sampler:?}: {rates:.4?}");
        rates
    };
    let guided = rates(Sampler::RejectionMix);
    assert!(guided[4] > 3.0 * guided[0], "{guided:?}");
    let unguided = rates(Sampler::Bsdf);
    assert!((unguided[4] / unguided[0] - 1.0).abs() < 0.2, "{unguided:?}");
    assert!((guided[0] / unguided[0] - 1.0).abs() < 1.0e-6, "the first step draws from the BSDF");
}

/// Few directions are lost below the surface, as in Table 1 of the paper. Samplers that do not know the normal lose many.
/// Cells use their own targets only. From cells with other surfaces they would borrow light at the horizon, where bins lie
/// below it in part.
#[test]
fn only_samplers_blind_to_the_normal_draw_below_the_surface() {
    let device = Device::validated();
    let scene = ours("cornell-box/scene.xml", &[]);
    for (sampler, learner) in combinations() {
        let settings =
            Settings { learner, min_uniform: 0.0625, fallback: Some(0.0), ..settings(&scene, [48, 48], sampler, 1) };
        let counts = steps(&mut device.renderer(&scene, &settings), &settings, 24);
        let last = counts[2];
        let (invalid, tries) = (last.invalid_rate(), last.tries_per_sample());
        println!("{sampler:?} and {learner:?}: {invalid:.4} invalid, {tries:.2} tries");
        let is_blind = matches!(sampler, Sampler::SphereInversion | Sampler::Quadtree);
        let is_expected = if is_blind { invalid > 0.05 } else { invalid < 0.01 };
        assert!(is_expected, "{sampler:?} and {learner:?}: {invalid}");
        // Plain rejection has no uniform share, so it needs more tries than the mix.
        let least = if sampler == Sampler::Rejection { 4.0 } else { 1.0 };
        assert!(tries >= least, "{sampler:?} and {learner:?}: {tries} tries");
    }
}

/// Learned shares favor the better sampler. A guide that knows no more than the surface hardly changes shares, and not
/// in its own favor. A guide that knows where the light is gets more than half. A guide that is coarser than the
/// metal's reflection gets little.
#[test]
fn shares_go_to_what_knows_more() {
    let device = Device::validated();
    let shares = |scene: &Scene, change: fn(&mut Settings)| {
        // Finer cells would need more samples to learn as much.
        let mut settings = Settings { grid: Some(8), ..settings(scene, [64, 64], Sampler::Product, 1) };
        change(&mut settings);
        let mut renderer = device.renderer(scene, &settings);
        assert!(renderer.bsdf_shares().expect("shares").iter().flatten().all(|&share| share == 0.5));
        steps(&mut renderer, &settings, 96);
        let shares = renderer.bsdf_shares().expect("shares");
        assert!(shares.iter().flatten().all(|share| (0.1..=0.9).contains(share)), "{shares:?}");
        let mean = |which: usize| {
            let learned = shares.iter().map(|share| share[which]).filter(|&share| share != 0.5);
            let (sum, count) = learned.fold((0.0, 0), |(sum, count), share| (sum + share, count + 1));
            (count > 0).then(|| sum / count as f32)
        };
        println!("{:?} {:?}", mean(0), mean(1));
        [mean(0), mean(1)]
    };
    let [of_lobes, of_wholes] = shares(&ours("furnace/scene.xml", &[]), |_| {});
    assert!((0.5..0.6).contains(&of_lobes.expect("a share")) && of_wholes.is_none(), "{of_lobes:?}");
    let [of_lobes, of_wholes] = shares(&ours("cornell-box-hard/scene.xml", &[]), |_| {});
    assert!(of_lobes.expect("a share") < 0.45 && of_wholes.is_none(), "{of_lobes:?}");
    let [_, of_wholes] = shares(&polished_box(), |s| s.guide_set = GuideSet::Authors);
    assert!(of_wholes.expect("a share") > 0.65, "{of_wholes:?}");
    assert!(shares_where_fixed(&device).is_empty());
}

/// Cornell box with a wall of almost polished metal.
fn polished_box() -> Scene {
    let mut scene = ours("cornell-box/scene.xml", &[]);
    let alpha = Textured::constant(0.05);
    let metal = Bsdf::RoughConductor {
        microfacets: Microfacets { distribution: Distribution::Ggx, alpha_u: alpha, alpha_v: alpha },
        eta: Vec3::ZERO,
        k: Vec3::ZERO,
        specular_reflectance: Textured::constant(Vec3::splat(0.9)),
    };
    let red = scene.materials.iter_mut().find(|material| material.name == "red").expect("a material");
    surface_mut(red).bsdf = metal;
    scene
}

fn shares_where_fixed(device: &Device) -> Vec<[f32; 2]> {
    let scene = ours("cornell-box/scene.xml", &[]);
    let settings = Settings { epsilon: Some(0.3), ..settings(&scene, [64, 64], Sampler::Product, 1) };
    device.renderer(&scene, &settings).bsdf_shares().expect("no shares")
}

#[test]
fn only_guided_samplers_count_guided_samples() {
    let device = Device::validated();
    let scene = ours("cornell-box/scene.xml", &[]);
    for sampler in SAMPLERS {
        let settings = settings(&scene, [64, 64], sampler, 1);
        let counts = steps(&mut device.renderer(&scene, &settings), &settings, 16);
        assert_eq!(counts[0].guided_samples, 0);
        assert_eq!(counts[1].guided_samples > 0, sampler != Sampler::Bsdf);
        assert!(counts.iter().all(|c| c.rays == c.scattered_rays + 64 * 64 * 8), "{counts:?}");
    }
}

/// Reconstruction filters keep the sum and blur the edge. The lamp, seen directly, fills some pixels and touches
/// others. It covers the same area with every filter.
#[test]
fn filters_keep_the_sum_and_blur_the_edge() {
    let device = Device::validated();
    let scene = ours("cornell-box/scene.xml", &[]);
    let filters = [
        ReconstructionFilter::Box,
        ReconstructionFilter::Tent { radius: 1.0 },
        ReconstructionFilter::Gaussian { stddev: 0.5 },
        ReconstructionFilter::Gaussian { stddev: 1.0 },
    ];
    let pictures: Vec<_> = filters
        .iter()
        .zip(40..)
        .map(|(&filter, seed)| {
            let settings = Settings { filter, max_depth: 1, ..settings(&scene, [64, 64], Sampler::Bsdf, seed) };
            device.render(&scene, &settings, 64)
        })
        .collect();
    let lit: Vec<usize> = pictures.iter().map(|p| p.radiance.iter().filter(|color| color[0] > 0.0).count()).collect();
    println!("pixels that see the lamp: {lit:?}");
    assert!(lit.is_sorted_by(|a, b| a < b), "{lit:?}");
    let (expected, expected_error) = Estimate::of(&pictures[0]).gray();
    assert!(expected > 0.05);
    for (picture, filter) in pictures.iter().zip(filters).skip(1) {
        let (mean, error) = Estimate::of(picture).gray();
        let z = (mean - expected) / error.hypot(expected_error);
        println!("{filter:?}: {mean:.5} +- {error:.5}, box {expected:.5} +- {expected_error:.5}, z = {z:.2}");
        assert!(sidak(two_sided(z), 3) > ALPHA, "{filter:?}: z = {z}");
        assert!(picture.radiance.iter().all(|color| color[0] <= 17.0001));
    }
    // All pixels are equal inside the furnace.
    let furnace = ours("furnace/mesh.xml", &[]);
    for filter in filters {
        let settings = Settings { filter, rr_depth: 1000, ..settings(&furnace, [16, 16], Sampler::Bsdf, 2) };
        let picture = device.render(&furnace, &settings, 8);
        assert!(picture.radiance.iter().flatten().all(|l| (l - 1.0).abs() < 2.0e-5), "{filter:?}");
    }
}

#[test]
fn hidden_emitters_still_light_the_scene() {
    let device = Device::validated();
    let scene = ours("cornell-box/scene.xml", &[]);
    let render = |hide_emitters, max_depth| {
        let settings = Settings { hide_emitters, max_depth, ..settings(&scene, [64, 64], Sampler::Bsdf, 4) };
        device.render(&scene, &settings, 8).radiance
    };
    let (shown, hidden) = (render(false, 4), render(true, 4));
    let differing: Vec<usize> = (0..shown.len()).filter(|&at| shown[at] != hidden[at]).collect();
    let lamp = render(false, 1);
    assert!(differing.iter().all(|&at| lamp[at][0] > 0.0) && differing.len() > 10, "{differing:?}");
    assert!(hidden.iter().any(|color| color[0] > 0.0));
    assert!(render(true, 1).iter().flatten().all(|&l| l == 0.0));
}

#[test]
fn a_stopped_step_leaves_a_valid_picture() {
    let device = Device::validated();
    let scene = ours("cornell-box/scene.xml", &[]);
    for sampler in SAMPLERS {
        // Slices have one workgroup each, so that a step has several slices on any device.
        let settings = Settings { slice_milliseconds: Some(0.001), ..settings(&scene, [128, 128], sampler, 4) };
        let mut renderer = device.renderer(&scene, &settings);
        steps(&mut renderer, &settings, 16);
        let asked = Cell::new(0);
        let stop = || asked.replace(asked.get() + 1) == 3;
        let report = renderer.step(8, &stop).expect("a step");
        assert!(!report.complete && report.counts.rays > 0);
        assert_eq!((renderer.samples_done(), asked.get()), (16, 4));
        let picture = renderer.picture().expect("a picture");
        let with = |count| picture.sample_count.iter().filter(|&&samples| samples == count).count();
        assert!(with(16) > 0 && with(24) > 0 && with(16) + with(24) == 128 * 128);
        assert!(picture.radiance.iter().flatten().all(|l| l.is_finite() && *l >= 0.0));
        // The interrupted picture's pixels have unequal numbers of samples. No step can follow, and the picture stays
        // as it is.
        assert!(renderer.step(8, &|| false).is_err());
        assert!(renderer.picture().expect("a picture").radiance == picture.radiance);
    }
}

#[test]
fn an_empty_scene_shows_its_environment() {
    let device = Device::validated();
    let mut scene = ours("furnace/scene.xml", &[]);
    scene.primitives.clear();
    scene.environment = Some(Environment::constant(vec3(0.25, 0.5, 0.75)));
    for sampler in SAMPLERS {
        let picture = device.render(&scene, &settings(&scene, [17, 9], sampler, 4), 16);
        assert!(picture.radiance.iter().all(|&color| color == [0.25, 0.5, 0.75]));
        let hidden = Settings { hide_emitters: true, ..settings(&scene, [17, 9], sampler, 4) };
        assert!(device.render(&scene, &hidden, 8).radiance.iter().all(|&color| color == [0.0; 3]));
    }
}

/// A driver's loop budget gives an error, not a dark picture. 64 paths of 1024 edges need all iterations that lavapipe
/// 22.3 grants one invocation.
#[test]
fn a_driver_s_loop_budget_is_an_error_and_no_dark_picture() {
    let device = Device::validated();
    let mut scene = ours("furnace/mesh.xml", &[("albedo", "1"), ("emission", "0.0009765625")]);
    scene.environment = None;
    for sampler in SAMPLERS {
        let settings = Settings {
            max_depth: 1024,
            rr_depth: u32::MAX,
            samples_per_dispatch: 64,
            ..settings(&scene, [8, 8], sampler, 4)
        };
        let mut renderer = device.renderer(&scene, &settings);
        match renderer.step(64, &|| false) {
            Err(Error::LoopCut(sentence)) => {
                println!("{sentence}");
                assert!(sentence.contains("ended a loop of a kernel before its end"), "{sentence}");
                assert!(sentence.contains("--samples-per-dispatch below 64"), "{sentence}");
                assert!(sentence.contains("or --execution wavefront or a smaller --max-depth"), "{sentence}");
            }
            Err(other) => panic!("{other}"),
            Ok(report) => {
                assert!(report.complete);
                let picture = renderer.picture().expect("a picture");
                assert!(picture.radiance.iter().flatten().all(|l| (l - 1.0).abs() < 1.0e-3), "{sampler:?}");
            }
        }
    }
}
