//! Renders of the furnace against its closed form.

use lodestar::renderer::Renderer;
use lodestar::settings::{Learner, Sampler, Settings};
use support::estimate::Estimate;
use support::mutated::{BRIGHTER, DENSITIES, TWICE_AS_BRIGHT};
use support::rows::samplers;
use support::scenes::{ours, settings, steady};
use support::significance::{ALPHA, sidak, two_sided};
use support::tier;

use crate::device::{Device, steps};

const SIZE: [u32; 2] = [32, 32];
const SPP: u32 = 64;
/// Radiance that paths of at most `n` edges bring.
const fn answer(edges: u32) -> f64 {
    1.0 - 1.0 / (1_u64 << edges) as f64
}

/// Deviation of the mean radiance from the closed form, in standard errors.
fn deviation(device: &Device, file: &str, defines: &[(&str, &str)], change: impl FnOnce(&mut Settings)) -> f64 {
    let scene = ours(file, defines);
    let mut settings = settings(&scene, SIZE, Sampler::Bsdf, 5);
    change(&mut settings);
    let settings = steady(settings);
    let depth = settings.max_depth;
    let (mean, error) = Estimate::of(&device.render(&scene, &settings, SPP)).gray();
    // Relative rounding error of a sum of 64 samples in single precision.
    let rounding = 1.0e-6;
    let z = (mean - answer(depth)) / error.hypot(rounding);
    println!("{file} {defines:?} {:?}: {mean:.6} +- {error:.6}, z = {z:.2}", settings.sampler);
    z
}

/// Mean radiance agrees with the closed form for the sphere and for its mesh, for all samplers, and for Russian
/// roulette that starts early or late. The quick tier has the sphere only.
#[test]
fn every_sampler_is_within_its_confidence_interval() {
    let device = Device::new();
    let files = tier::some_of(&["furnace/scene.xml", "furnace/mesh.xml"], 1);
    let cases: Vec<_> = files
        .iter()
        .flat_map(|&file| {
            samplers()
                .into_iter()
                .map(move |sampler| tier::some_of(&[2, 8], 1).iter().map(move |&rr| (file, sampler, rr)))
        })
        .flatten()
        .collect();
    for &(file, sampler, rr_depth) in &cases {
        let set = |s: &mut Settings| (s.sampler, s.rr_depth) = (sampler, rr_depth);
        let z = deviation(&device, file, &[], set);
        assert!(sidak(two_sided(z), cases.len()) > ALPHA, "{file} {sampler:?} roulette {rr_depth}: z = {z}");
    }
}

/// Inversion agrees with the closed form at a uniform share of 1/16. Paths are so short that no path has a much
/// larger weight than others. The quick tier has one sampler by inversion.
#[test]
fn inversion_is_right_at_a_small_share() {
    let device = Device::new();
    let faulty = device.mutated(DENSITIES);
    let scene = ours("furnace/scene.xml", &[]);
    for &sampler in tier::some_of(&[Sampler::HemisphereInversion, Sampler::SphereInversion], 1) {
        let z = |device: &Device| {
            let short = Settings { max_depth: 3, min_uniform: 0.0625, ..settings(&scene, SIZE, sampler, 6) };
            let (mean, error) = Estimate::of(&device.render(&scene, &short, 256)).gray();
            println!("{sampler:?}, {}: {mean:.6} +- {error:.6}", device.mutation());
            (mean - answer(3)) / error
        };
        let (right, twin) = (z(&device), z(&faulty));
        assert!(
            sidak(two_sided(right), 4) > ALPHA && sidak(two_sided(twin), 4) < ALPHA,
            "{sampler:?}: {right}, {twin}"
        );
    }
}

/// The twins must fail: densities that are 5 % off, and an albedo that is 3 % off. The quick tier has them for two
/// samplers.
#[test]
fn a_wrong_density_or_albedo_is_found_in_the_furnace() {
    let device = Device::new();
    let faulty = device.mutated(DENSITIES);
    for &sampler in tier::some_of(&samplers(), 2) {
        let set = |s: &mut Settings| s.sampler = sampler;
        for (albedo, z) in [
            ("0.5", deviation(&faulty, "furnace/scene.xml", &[], set)),
            ("0.515", deviation(&device, "furnace/scene.xml", &[("albedo", "0.515")], set)),
        ] {
            assert!(sidak(two_sided(z), 4 * samplers().len()) < ALPHA, "{sampler:?} with albedo {albedo}: z = {z}");
        }
    }
}

/// Depth counts edges. Without Russian roulette the BSDF sampler has no noise here: every path brings the same
/// radiance.
#[test]
fn depth_counts_edges() {
    let device = Device::new();
    for (max_depth, hide_emitters) in [(1, false), (2, false), (3, false), (16, false), (1, true), (2, true), (3, true)]
    {
        let scene = ours("furnace/mesh.xml", &[]);
        let settings =
            Settings { max_depth, hide_emitters, rr_depth: 1000, ..settings(&scene, [16, 8], Sampler::Bsdf, 1) };
        let picture = device.render(&scene, &settings, 8);
        // The camera sees nothing behind hidden walls.
        let expected = if hide_emitters { 0.0 } else { answer(max_depth) };
        let worst = picture.radiance.iter().flatten().map(|&l| (f64::from(l) - expected).abs()).fold(0.0, f64::max);
        assert!(worst < 2.0e-6, "depth {max_depth}, hidden {hide_emitters}: off by {worst}");
    }
}

/// Radiance of the bins that have learned something. Other bins have a 64th of their cell's mean.
fn learned_bins(renderer: &Renderer) -> Vec<f64> {
    renderer.radiance().expect("a table").into_iter().map(f64::from).filter(|&l| l > 0.2).collect()
}

fn mean_and_deviation(values: &[f64], expected: f64) -> (f64, f64) {
    let n = values.len() as f64;
    let squared: f64 = values.iter().map(|value| (value - expected).powi(2)).sum();
    (values.iter().sum::<f64>() / n, (squared / n).sqrt())
}

/// Radiance that 24 steps learn in the furnace: its mean over bins, and the root-mean-square deviation of bins from
/// `expected`.
fn learned(device: &Device, defines: &[(&str, &str)], expected: f64, change: impl FnOnce(&mut Settings)) -> (f64, f64) {
    let scene = ours("furnace/scene.xml", defines);
    let mut settings =
        Settings { grid: Some(4), directions: 8, ..settings(&scene, [64, 64], Sampler::RejectionMix, 9) };
    change(&mut settings);
    let mut renderer = device.renderer(&scene, &settings);
    steps(&mut renderer, &settings, LEARNING_STEPS * 8);
    let bins = learned_bins(&renderer);
    let (mean, rms) = mean_and_deviation(&bins, expected);
    let (learner, mutation) = (settings.learner, device.mutation());
    println!("{learner:?}, {mutation}: {} bins, mean {mean:.4} (expected {expected:.4}), rms {rms:.4}", bins.len());
    assert!(bins.len() > 1000, "{}", bins.len());
    (mean, rms)
}

const LEARNING_STEPS: u32 = 24;

fn is_learned((mean, rms): (f64, f64), expected: f64) -> bool {
    (mean - expected).abs() < 0.01 && rms < 0.05
}

/// The table tends to the incident radiance, 1, at the predicted rate. The targets of each step are 0.5 + 0.5 L of the
/// step before (Eq. 5, Eq. 6). With rates alpha_k = 1 / (1 + decay + ... + decay^(k-1)), the distance to 1 shrinks by
/// the factor 1 - alpha_k / 2 in step k. The quick tier has two learners.
#[test]
fn the_radiance_table_tends_to_the_incident_radiance() {
    let device = Device::new();
    let cases = [
        (Learner::Sarsa, 0.95),
        (Learner::ExpectedSarsa, 1.0),
        (Learner::Sarsa, 0.0),
        (Learner::Sarsa, 1.0),
        (Learner::ExpectedSarsa, 0.95),
    ];
    for &(learner, decay) in tier::some_of(&cases, 2) {
        let (mut distance, mut weight) = (1.0, 0.0);
        for _ in 0..LEARNING_STEPS {
            weight = weight * f64::from(decay) + 1.0;
            distance *= 1.0 - 0.5 / weight;
        }
        let found = learned(&device, &[], 1.0 - distance, |s| (s.learner, s.decay) = (learner, decay));
        assert!(is_learned(found, 1.0 - distance), "{learner:?}, decay {decay}: {found:?}");
    }
}

/// Parent cells change nothing in a furnace, because neighbors have the same radiance. The long tier has the twin.
#[test]
fn cells_that_fall_back_on_their_parents_tend_to_the_incident_radiance() {
    let device = Device::new();
    let fall_back = |s: &mut Settings| (s.grid, s.fallback, s.decay) = (Some(7), Some(20.0), 0.0);
    let expected = 1.0 - 0.5_f64.powi(LEARNING_STEPS as i32);
    let found = learned(&device, &[], expected, fall_back);
    assert!(is_learned(found, expected), "{found:?}");
    if tier::is_full() {
        let faulty = learned(&device.mutated(BRIGHTER), &[], expected, fall_back);
        assert!(!is_learned(faulty, expected), "the twin, 5 % off: {faulty:?}");
    }
}

/// Monte Carlo learns the mean return. A path of 16 edges returns 1 - 2^-(17 - e) from edge e on. Edges 2 to 15 are
/// recorded. The quick tier has one sampler.
#[test]
fn monte_carlo_learns_the_mean_return() {
    let device = Device::new();
    let expected = (2..=15).map(|edge| answer(17 - edge)).sum::<f64>() / 14.0;
    for &sampler in tier::some_of(&[Sampler::RejectionMix, Sampler::HemisphereInversion], 1) {
        let set = |s: &mut Settings| {
            (s.sampler, s.learner, s.decay, s.rr_depth) = (sampler, Learner::MonteCarlo, 1.0, 1000);
        };
        let found = learned(&device, &[], expected, set);
        assert!(is_learned(found, expected), "{sampler:?}: {found:?}");
    }
}

/// Returns are divided by the probability of survival. With an albedo of 0.9, the mean return from edge e on is 1 -
/// 0.9^(17 - e), although Russian roulette starts at vertex 6. Its probability is the throughput, which is 1 after each
/// division. The render has one step, because the weights of a guide would change the throughput.
#[test]
fn monte_carlo_divides_by_survival() {
    let device = Device::new();
    let survival = |vertex: i32| match vertex {
        ..6 => 1.0,
        6 => 0.9_f64.powi(6),
        _ => 0.9,
    };
    let reached = |edge: i32| (1..edge).map(survival).product::<f64>();
    let sum = |f: &dyn Fn(i32) -> f64| (2..=15).map(|edge| reached(edge) * f(edge)).sum::<f64>();
    let mean = |weight: f64| sum(&|edge| 1.0 - (0.9 * weight).powi(17 - edge)) / sum(&|_| 1.0);
    let found = learned(&device, &[("albedo", "0.9"), ("emission", "0.1")], mean(1.0), |s| {
        (s.learner, s.decay, s.rr_depth, s.spp_per_step) = (Learner::MonteCarlo, 1.0, 6, LEARNING_STEPS * 8);
    });
    // Returns of few paths have large weights. They are noisy in one bin, but not over all bins. (Cut off at 16 times
    // the emission, their mean is 0.012 too low.)
    let is_near = |expected: f64| (found.0 - expected).abs() < 0.01;
    assert!(is_near(mean(1.0)), "{found:?}, not {}", mean(1.0));
    assert!(!is_near(mean(0.95)), "the twin: an albedo 5 % off");
}

/// The twins must fail: a learner without the surface's attenuation never reaches the closed form, and neither does one
/// that takes surfaces to be 5 % brighter. The quick tier has them for one learner.
#[test]
fn a_learner_without_attenuation_is_found() {
    let device = Device::new();
    let learners = [Learner::Sarsa, Learner::ExpectedSarsa, Learner::MonteCarlo];
    for &learner in tier::some_of(&learners, 1) {
        let faulty = |mutation| learned(&device.mutated(mutation), &[], 1.0, |s| (s.learner, s.decay) = (learner, 0.5));
        let found = faulty(TWICE_AS_BRIGHT);
        assert!(!is_learned(found, 1.0) && found.0 > 1.5, "{learner:?}: {found:?}");
        let slightly = faulty(BRIGHTER);
        assert!(!is_learned(slightly, 1.0), "{learner:?}, 5 % off: {slightly:?}");
    }
}
