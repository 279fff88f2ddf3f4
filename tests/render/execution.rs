//! Wave execution gives the bits of the megakernel.

use glam::Vec3;
use lodestar::renderer::Counts;
use lodestar::scene::emitter::AreaEmitter;
use lodestar::scene::{Environment, EnvironmentKind, Scene, Textured};
use lodestar::settings::{Execution, Learner, SamplePattern, SampleWeights, Sampler, Settings};
use support::panes::with_panes;
use support::rows::{Held, held_to};
use support::scenes::{ours, settings};
use support::tier;

use crate::determinism::bits;
use crate::device::Device;

/// Change of the settings.
type Change = fn(&mut Settings);

/// Size that is not a whole number of tiles. The samples take several steps.
const SIZE: [u32; 2] = [52, 37];
const SPP: u32 = 21;

/// Bits of the picture, and the counts of the render.
fn rendered(device: &Device, scene: &Scene, settings: &Settings) -> (Vec<u32>, Counts) {
    let mut renderer = device.renderer(scene, settings);
    let mut counts = Counts::default();
    while renderer.samples_done() < SPP {
        let samples = settings.spp_per_step.min(SPP - renderer.samples_done());
        counts.add(&renderer.step(samples, &|| false).expect("a step").counts);
    }
    (bits(&renderer.picture().expect("a picture")), counts)
}

/// Compares waves with the megakernel. The waves have small slices and pages, and queues that few workgroups process.
fn compare(device: &Device, name: &str, scene: &Scene, change: impl Fn(&mut Settings)) {
    let render = |further: &dyn Fn(&mut Settings)| {
        let mut settings = settings(scene, SIZE, Sampler::Product, 11);
        change(&mut settings);
        further(&mut settings);
        rendered(device, scene, &settings)
    };
    let wave = |s: &mut Settings| {
        (s.execution, s.queue_groups) = (Execution::Wavefront, Some(3));
        (s.slice_milliseconds, s.film_page_pixels) = (Some(1.0), Some(1024));
    };
    assert!(render(&|s| s.execution = Execution::Megakernel) == render(&wave), "{name}");
}

#[test]
fn however_waves_are_cut_they_change_no_bit() {
    let device = Device::validated();
    let scene = ours("cornell-box/scene.xml", &[]);
    let render = |further: &dyn Fn(&mut Settings)| {
        let mut settings = settings(&scene, SIZE, Sampler::Product, 11);
        (settings.nee, settings.execution) = (true, Execution::Wavefront);
        further(&mut settings);
        rendered(&device, &scene, &settings)
    };
    let megakernel = render(&|s| s.execution = Execution::Megakernel);
    assert!(megakernel == render(&|_| {}));
    assert!(megakernel == render(&|s| s.slice_milliseconds = Some(1.0)), "slices of 1 ms");
    assert!(megakernel == render(&|s| s.film_page_pixels = Some(256)), "film pages");
    assert!(megakernel == render(&|s| s.queue_groups = Some(1)), "queues of one workgroup");
    assert!(megakernel != render(&|s| s.seed = 12), "another seed");
}

#[test]
fn light_that_is_no_number_is_lost_alike() {
    let device = Device::validated();
    for &radiance in tier::some_of(&[f32::NAN, f32::INFINITY], 1) {
        let mut scene = ours("cornell-box/scene.xml", &[]);
        for emitter in &mut scene.emitters {
            *emitter = AreaEmitter::new(Textured::constant(Vec3::new(1.0, radiance, 1.0)));
        }
        for &sampler in tier::some_of(&[Sampler::Product, Sampler::Bsdf], 1) {
            compare(&device, &format!("{sampler:?}, {radiance}"), &scene, |s| (s.sampler, s.nee) = (sampler, true));
        }
    }
}

#[test]
fn waves_change_no_bit_of_any_sampler() {
    let device = Device::validated();
    let scene = ours("cornell-box/scene.xml", &[]);
    compare(&device, "bsdf", &scene, |s| s.sampler = Sampler::Bsdf);
    compare(&device, "product", &scene, |_| {});
    compare(&device, "bsdf, emitters sampled", &scene, |s| (s.sampler, s.nee) = (Sampler::Bsdf, true));
    for row in tier::some_of(&held_to(Held::Guided), 2) {
        let mut changed = settings(&scene, SIZE, Sampler::Product, 11);
        row.set(&mut changed);
        if changed.learner != Learner::MonteCarlo {
            compare(&device, row.name, &scene, |s| {
                row.set(s);
                s.nee = true;
            });
        }
    }
}

#[test]
fn waves_change_no_bit_of_any_scene() {
    let device = Device::validated();
    for name in tier::some_of(&["lights", "door-ajar", "furnace", "cornell-box-hard"], 1) {
        let scene = ours(&format!("{name}/scene.xml"), &[]);
        compare(&device, name, &scene, |s| s.nee = true);
        compare(&device, &format!("{name}, roulette from the start"), &scene, |s| (s.max_depth, s.rr_depth) = (3, 1));
    }
    compare(&device, "panes", &with_panes(ours("cornell-box/scene.xml", &[])), |s| s.nee = true);
    if tier::is_full() {
        let hidden = with_panes(ours("cornell-box/scene.xml", &[]));
        compare(&device, "panes, hidden emitters", &hidden, |s| (s.nee, s.hide_emitters) = (false, true));
        compare(&device, "panes, bsdf", &hidden, |s| (s.nee, s.hide_emitters, s.sampler) = (true, true, Sampler::Bsdf));
    }
    // The sky is cut into patches, so each cell selects among 256 groups of lights.
    let mut scene = ours("door-ajar/scene.xml", &[]);
    let kind = EnvironmentKind::Constant { radiance: Vec3::ONE };
    scene.environment = Some(Environment { kind, sampling_weight: 1.0 });
    compare(&device, "a door under a sky", &scene, |s| s.nee = true);
}

#[test]
fn waves_change_no_bit_of_any_option() {
    let device = Device::validated();
    let scene = ours("door-ajar/scene.xml", &[]);
    let changes: [(&str, Change); 10] = [
        ("deeper than a submission", |s| (s.max_depth, s.rr_depth) = (40, 40)),
        ("sets of samples", |s| s.pattern = SamplePattern::Sobol),
        ("storage", |s| s.storage_reads = true),
        ("a part of a picture", |s| s.sample_offset = Some(5)),
        ("three samples a dispatch", |s| s.samples_per_dispatch = 3),
        ("one edge", |s| s.max_depth = 1),
        ("weights by a schedule", |s| s.sample_weights = Some(SampleWeights::Growing)),
        ("blue noise", |s| s.pattern = SamplePattern::BlueNoise),
        ("larger cells", |s| s.fallback = Some(8.0)),
        ("hidden emitters", |s| s.hide_emitters = true),
    ];
    for (name, set) in tier::some_of(&changes, 1) {
        compare(&device, name, &scene, |s| {
            s.nee = true;
            set(s);
        });
    }
}
