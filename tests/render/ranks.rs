//! Several devices render one picture with the bits of one device.

use lodestar::fleet::Fleet;
use lodestar::fleet::sums::{self, AddSums, Sums};
use lodestar::renderer::{Counts, RenderState};
use lodestar::scene::Scene;
use lodestar::settings::{Execution, Learner, Sampler, Settings};
use support::panes::with_panes;
use support::rows::combinations;
use support::scenes::{ours, settings};
use support::tier;

use crate::determinism::bits;
use crate::device::{Device, steps};

/// Size that is not a whole number of tiles, so that devices have unequal shares.
pub const SIZE: [u32; 2] = [44, 29];
/// Samples per pixel: several steps, and a part of one.
pub const SPP: u32 = 28;

pub fn scene() -> Scene {
    ours("cornell-box/scene.xml", &[])
}

/// Renderers of one scene, each with a device of its own, that share a film.
struct Ranks {
    fleet: Fleet,
    _devices: Vec<Device>,
}

impl Ranks {
    fn new(scene: &Scene, settings: &Settings, ranks: usize) -> Self {
        Self::with_sums(scene, settings, ranks, sums::add)
    }

    /// Renderers whose sums are added up by `add`.
    fn with_sums(scene: &Scene, settings: &Settings, ranks: usize, add: AddSums) -> Self {
        let devices: Vec<_> = (0..ranks).map(|_| Device::new()).collect();
        let mut renderers = devices.iter().map(|device| device.renderer(scene, settings));
        let first = renderers.next().expect("a device");
        let fleet = Fleet::with_sums(first, renderers.collect(), add).expect("renderers without samples");
        assert_eq!(fleet.device_count(), ranks);
        Self { fleet, _devices: devices }
    }
}

/// Everything that a render leaves: its picture, its state (where its last step was whole) and the counts of its steps.
pub type Left = (Vec<u32>, RenderState, Vec<Counts>);

/// Everything that a renderer without a fleet leaves.
pub fn left_by_one(scene: &Scene, settings: &Settings, spp: u32) -> Left {
    let device = Device::new();
    let mut renderer = device.renderer(scene, settings);
    let counts = steps(&mut renderer, settings, spp);
    (bits(&renderer.picture().expect("a picture")), renderer.state().expect("a state"), counts)
}

/// Everything that a fleet leaves.
pub fn left(fleet: &mut Fleet, settings: &Settings, spp: u32) -> Left {
    let mut counts = Vec::new();
    while fleet.first().samples_done() < spp {
        let samples = settings.spp_per_step.min(spp - fleet.first().samples_done());
        counts.push(fleet.step(samples, &|| false).expect("a step").counts);
    }
    (bits(&fleet.picture().expect("a picture")), fleet.state().expect("a state"), counts)
}

/// Number of configurations in the quick tier: the first ones.
const IN_QUICK_TIER: usize = 4;

/// Settings with names: samplers and learners, emitter sampling, waves, ends by noise, parts, several film pages.
pub fn configurations(scene: &Scene) -> Vec<(String, Settings)> {
    let with = |sampler: Sampler, change: &dyn Fn(&mut Settings)| {
        let mut settings = settings(scene, SIZE, sampler, 21);
        change(&mut settings);
        settings
    };
    let mut all = vec![
        ("noise".into(), with(Sampler::RejectionMix, &|s| s.noise = Some(0.2))),
        ("quadtrees".into(), with(Sampler::Quadtree, &|_| {})),
        ("waves".into(), with(Sampler::Product, &|s| s.execution = Execution::Wavefront)),
        ("film pages".into(), with(Sampler::RejectionMix, &|s| s.film_page_pixels = Some(256))),
        ("bsdf".into(), with(Sampler::Bsdf, &|_| {})),
        ("one kernel".into(), with(Sampler::Product, &|s| s.execution = Execution::Megakernel)),
        ("no emitter sampling".into(), with(Sampler::RejectionMix, &|s| s.nee = false)),
        ("a part".into(), with(Sampler::RejectionMix, &|s| s.sample_offset = Some(64))),
    ];
    for (sampler, learner) in combinations() {
        all.push((format!("{sampler:?} and {learner:?}"), with(sampler, &|s| s.learner = learner)));
    }
    all
}

#[test]
fn any_number_of_devices_gives_the_bits_of_one() {
    let scene = scene();
    let all = configurations(&scene);
    let all = tier::some_of(&all, IN_QUICK_TIER);
    let ranks: &[usize] = if tier::is_full() { &[2, 3, 4] } else { &[2, 3] };
    for (name, settings) in all {
        let one = left_by_one(&scene, settings, SPP);
        for &ranks in ranks {
            let several = left(&mut Ranks::new(&scene, settings, ranks).fleet, settings, SPP);
            assert!(several.0 == one.0, "{name}, {ranks} devices: picture");
            assert_eq!(several.2, one.2, "{name}, {ranks} devices: counts");
            for (theirs, ours) in several.1.parts.iter().zip(&one.1.parts) {
                assert!(theirs == ours, "{name}, {ranks} devices: {}", ours.name);
            }
        }
    }
    println!("{} configurations", all.len());
}

/// Devices share a picture whose light comes through holes and glass.
#[test]
fn devices_share_light_that_goes_straight_on() {
    let scene = with_panes(scene());
    let settings = Settings { nee: true, ..settings(&scene, SIZE, Sampler::Product, 21) };
    let one = left_by_one(&scene, &settings, SPP);
    let several = left(&mut Ranks::new(&scene, &settings, 2).fleet, &settings, SPP);
    assert!(several.0 == one.0 && several.2 == one.2);
}

/// Tiles may be dealt out unevenly, and a device may have none.
#[test]
fn any_deal_of_the_tiles_gives_the_same_bits() {
    let scene = scene();
    let all = configurations(&scene);
    for (name, settings) in tier::some_of(&all, IN_QUICK_TIER) {
        let one = left_by_one(&scene, settings, SPP);
        for weights in [&[3, 1][..], &[1, 0, 2]] {
            let mut ranks = Ranks::new(&scene, settings, weights.len());
            ranks.fleet.deal(weights).expect("renderers without samples");
            assert!(left(&mut ranks.fleet, settings, SPP) == one, "{name}, weights {weights:?}");
        }
        // What is traced to measure the speeds must leave nothing behind.
        let mut ranks = Ranks::new(&scene, settings, 2);
        let weights = ranks.fleet.deal_by_speed().expect("renderers without samples");
        assert!(left(&mut ranks.fleet, settings, SPP) == one, "{name}, weights by speed {weights:?}");
    }
}

/// The comparison finds sums that are lost on the way, and sums that are added twice.
#[test]
fn wrong_sums_are_found() {
    let scene = scene();
    let add_twice = |total: &mut Sums, sums: &Sums| {
        sums::add(total, sums);
        sums::add(total, sums);
    };
    let faults: [(&str, AddSums); 2] = [("one device's sums are lost", |_, _| {}), ("sums are added twice", add_twice)];
    for sampler in [Sampler::RejectionMix, Sampler::Quadtree] {
        let settings = settings(&scene, SIZE, sampler, 21);
        let one = left_by_one(&scene, &settings, SPP);
        for (name, add) in faults {
            let several = left(&mut Ranks::with_sums(&scene, &settings, 2, add).fleet, &settings, SPP);
            assert!(several.0 != one.0 && several.1 != one.1, "{sampler:?}: {name}, but nothing differs");
        }
    }
}

/// Checkpoints go on with any number of devices.
#[test]
fn a_resumed_render_may_have_another_number_of_devices() {
    let scene = scene();
    for (sampler, learner) in [(Sampler::RejectionMix, Learner::Sarsa), (Sampler::Quadtree, Learner::MonteCarlo)] {
        let settings = Settings { learner, ..settings(&scene, SIZE, sampler, 21) };
        let whole = left_by_one(&scene, &settings, SPP);
        for (before, after) in [(1, 3), (3, 2), (2, 1)] {
            let mut first = Ranks::new(&scene, &settings, before);
            let (_, state, _) = left(&mut first.fleet, &settings, 16);
            let mut second = Ranks::new(&scene, &settings, after);
            second.fleet.restore(&state).expect("the same settings");
            let rest = left(&mut second.fleet, &settings, SPP);
            assert!(rest.0 == whole.0 && rest.1 == whole.1, "{sampler:?}: {before}, then {after} devices");
        }
    }
}
