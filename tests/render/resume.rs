//! Resumed renders have the bits of renders that were never interrupted.

use lodestar::renderer::{Counts, RenderState, Renderer};
use lodestar::scene::Scene;
use lodestar::settings::{AUTO_GRID, Execution, Sampler, Settings};
use support::panes::{Pane, covered};
use support::rows::combinations;
use support::scenes::{SAMPLERS, ours, settings};
use support::tier;

use crate::determinism::bits;
use crate::device::{Device, steps};

/// Size that is not a whole number of tiles.
const SIZE: [u32; 2] = [60, 41];
/// Samples per pixel: several steps, and a part of one.
const SPP: u32 = 44;

fn scene() -> Scene {
    ours("cornell-box/scene.xml", &[])
}

/// Bits of the picture after the remaining samples, and the counts of their steps.
fn rest(renderer: &mut Renderer, settings: &Settings) -> (Vec<u32>, Vec<Counts>) {
    let counts = steps(renderer, settings, SPP);
    (bits(&renderer.picture().expect("a picture")), counts)
}

fn state_after(device: &Device, scene: &Scene, settings: &Settings, spp: u32) -> (RenderState, Vec<Counts>) {
    let mut renderer = device.renderer(scene, settings);
    let counts = steps(&mut renderer, settings, spp);
    (renderer.state().expect("a state"), counts)
}

/// Whether a part of a render's state has this name.
type IsPart = fn(&str) -> bool;

/// A path within holes has more to remember than another one.
#[test]
fn a_resumed_render_has_the_same_bits_behind_holes() {
    let device = Device::validated();
    let scene = covered(ours("lights/floor.xml", &[("light", "rectangle")]), &[Pane::Mask(0.4), Pane::Blend(0.3)]);
    for (sampler, execution) in [(Sampler::Product, Execution::Megakernel), (Sampler::Bsdf, Execution::Wavefront)] {
        let settings = Settings { execution, nee: true, ..settings(&scene, [24, 16], sampler, 22) };
        let whole = rest(&mut device.renderer(&scene, &settings), &settings);
        let (state, mut counts) = state_after(&device, &scene, &settings, 16);
        let mut renderer = device.renderer(&scene, &settings);
        renderer.restore(&state).expect("the same settings");
        let (picture, later) = rest(&mut renderer, &settings);
        counts.extend(later);
        assert!(picture == whole.0, "{sampler:?}, {execution:?}: picture");
        assert_eq!(counts, whole.1, "{sampler:?}, {execution:?}: counts");
    }
}

#[test]
fn a_resumed_render_has_the_bits_of_one_never_interrupted() {
    let device = Device::validated();
    let scene = scene();
    for sampler in SAMPLERS {
        let settings = settings(&scene, SIZE, sampler, 21);
        let whole = rest(&mut device.renderer(&scene, &settings), &settings);
        for (spp, page_pixels, slice) in
            [(0, None, None), (8, Some(256), None), (16, None, Some(1.0)), (40, Some(512), None)]
        {
            let cut = Settings { film_page_pixels: page_pixels, slice_milliseconds: slice, ..settings.clone() };
            let (state, mut counts) = state_after(&device, &scene, &cut, spp);
            // Pages and slices differ before and after.
            let mut renderer = device.renderer(&scene, &settings);
            renderer.restore(&state).expect("the same settings");
            assert!(renderer.state().expect("a state") == state, "{sampler:?} {spp}");
            let (picture, later) = rest(&mut renderer, &settings);
            counts.extend(later);
            assert!(picture == whole.0, "{sampler:?} from {spp}: picture");
            assert_eq!(counts, whole.1, "{sampler:?} from {spp}: counts");
        }
    }
}

/// All combinations of sampler and learner resume with equal bits: a checkpoint restores the guide and everything
/// derived from it.
#[test]
fn every_combination_goes_on_with_the_same_bits() {
    let device = Device::validated();
    let scene = scene();
    for (sampler, learner) in combinations() {
        let settings = Settings { learner, ..settings(&scene, [24, 17], sampler, 21) };
        let render = |renderer: &mut Renderer| {
            let counts = steps(renderer, &settings, 28);
            (bits(&renderer.picture().expect("a picture")), counts.last().copied())
        };
        let whole = render(&mut device.renderer(&scene, &settings));
        let (state, _) = state_after(&device, &scene, &settings, 16);
        let mut renderer = device.renderer(&scene, &settings);
        renderer.restore(&state).expect("the same settings");
        assert!(render(&mut renderer) == whole, "{sampler:?} and {learner:?}");
    }
}

/// Parent cells resume with equal bits. They are not saved: every step computes them again from the saved cells.
#[test]
fn cells_that_fall_back_on_their_parents_go_on_with_the_same_bits() {
    let device = Device::validated();
    let scene = scene();
    let plain = settings(&scene, SIZE, Sampler::Product, 21);
    let settings = Settings { grid: Some(AUTO_GRID), fallback: Some(4.0), ..plain.clone() };
    let whole = rest(&mut device.renderer(&scene, &settings), &settings);
    let (state, _) = state_after(&device, &scene, &settings, 16);
    let mut renderer = device.renderer(&scene, &settings);
    renderer.restore(&state).expect("the same settings");
    assert!(rest(&mut renderer, &settings).0 == whole.0);
    // The twins must fail: each of the settings matters.
    for other in [Settings { grid: Some(7), ..settings.clone() }, Settings { fallback: Some(5.0), ..settings.clone() }]
    {
        assert!(rest(&mut device.renderer(&scene, &other), &other).0 != whole.0, "{other:?}");
    }
}

/// A resumed part has equal bits in sums that do not depend on the order of steps.
#[test]
fn a_resumed_part_has_the_bits_of_one_never_interrupted() {
    let device = Device::validated();
    let scene = scene();
    let part = Settings { sample_offset: Some(24), ..settings(&scene, SIZE, Sampler::Bsdf, 21) };
    let whole = rest(&mut device.renderer(&scene, &part), &part);
    let (state, _) = state_after(&device, &scene, &Settings { film_page_pixels: Some(256), ..part.clone() }, 16);
    let mut renderer = device.renderer(&scene, &part);
    renderer.restore(&state).expect("the same settings");
    assert!(rest(&mut renderer, &part).0 == whole.0);
}

/// The twins of the tests above must fail: renders that resume from a state that lacks a part. Every part matters,
/// except those that a plain path tracer does not use. The quick tier has one sampler.
#[test]
fn a_state_that_lacks_a_part_is_noticed() {
    let device = Device::validated();
    let scene = scene();
    // Only sphere inversion has ends of bins, and all normals have the same entry there. Only the product sampler and
    // quadtrees have nodes, and only they learn over several steps.
    let cases: [(Sampler, IsPart); 4] = [
        (Sampler::RejectionMix, |name| !["bin ends", "radiance nodes"].contains(&name)),
        (Sampler::SphereInversion, |name| name == "bin ends"),
        (Sampler::Product, |name| name == "radiance nodes"),
        (Sampler::Quadtree, |name| ["radiance nodes", "radiance sums"].contains(&name)),
    ];
    for &(sampler, matters) in tier::some_of(&cases, 1) {
        let settings = settings(&scene, SIZE, sampler, 21);
        let whole = rest(&mut device.renderer(&scene, &settings), &settings).0;
        let state = state_after(&device, &scene, &settings, 16).0;
        for part in (0..state.parts.len()).filter(|&part| matters(&state.parts[part].name)) {
            let mut lacking = state.clone();
            lacking.parts[part].bytes.fill(0);
            let mut renderer = device.renderer(&scene, &settings);
            renderer.restore(&lacking).expect("the same settings");
            assert!(rest(&mut renderer, &settings).0 != whole, "{sampler:?}: {}", state.parts[part].name);
        }
    }
}

#[test]
fn a_state_of_other_settings_is_refused_and_so_is_one_of_a_stopped_step() {
    let device = Device::validated();
    let scene = scene();
    let settings = settings(&scene, SIZE, Sampler::RejectionMix, 21);
    let state = state_after(&device, &scene, &settings, 8).0;
    for other in [Settings { grid: Some(4), ..settings.clone() }, Settings { width: 90, ..settings.clone() }] {
        let error = device.renderer(&scene, &other).restore(&state).unwrap_err().to_string();
        assert!(error.contains("the saved state holds film radiance: "), "{error}");
    }
    let mut renderer = device.renderer(&scene, &settings);
    renderer.step(8, &|| true).expect("a step");
    assert!(renderer.state().is_err());
    renderer.restore(&state).expect("the same settings");
    assert!(renderer.state().expect("a state") == state);
}

/// Sample offsets give disjoint ranges of samples. The mean of two renders of 16 samples, at offsets 0 and 16, is the
/// picture of one render of 32 samples, up to rounding.
#[test]
fn a_sample_offset_moves_the_range() {
    let device = Device::validated();
    let scene = scene();
    let whole = settings(&scene, SIZE, Sampler::Bsdf, 21);
    let part = |offset: u32, spp: u32| {
        let settings = Settings { sample_offset: Some(offset), ..whole.clone() };
        device.render(&scene, &settings, spp)
    };
    let (a, b, all) = (part(0, 16), part(16, 16), part(0, 32));
    assert!(bits(&a) != bits(&b));
    for ((a, b), all) in a.radiance.iter().zip(&b.radiance).zip(&all.radiance) {
        for channel in 0..3 {
            let mean = 0.5 * (a[channel] + b[channel]);
            assert!((mean - all[channel]).abs() <= 1.0e-5 * mean.max(1.0e-3), "{mean} {}", all[channel]);
        }
    }
}
