//! Samples in sets against independent samples.

use lodestar::film::Picture;
use lodestar::image::Image;
use lodestar::scene::Scene;
use lodestar::settings::{SamplePattern, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::mutated::DENSITIES;
use support::scenes::{ours, settings};
use support::tier;

use crate::determinism::bits;
use crate::device::Device;

const SIZE: [u32; 2] = [24, 24];
const SPP: u32 = 32;
const PICTURES: u32 = 24;
/// Patterns with sets of samples.
const SETS: [SamplePattern; 2] = [SamplePattern::Sobol, SamplePattern::BlueNoise];
/// Samples per step. The number neither divides the size of a set nor is a multiple of it, so that steps cut sets in
/// two.
const STEP: u32 = 5;

struct Studio {
    device: Device,
    scene: Scene,
}

impl Studio {
    fn new() -> Self {
        Self { device: Device::new(), scene: ours("cornell-box/scene.xml", &[]) }
    }

    fn settings(&self, sampler: Sampler, pattern: SamplePattern, seed: u32) -> Settings {
        Settings { pattern, nee: true, spp_per_step: STEP, ..settings(&self.scene, SIZE, sampler, seed) }
    }

    /// Mean of pictures with different seeds, with a variance from their spread. Nothing is assumed about the samples
    /// of one picture. Pixels are summed to blocks first, which are close to normally distributed.
    fn estimate(&self, first_seed: u32, change: &dyn Fn(&mut Settings)) -> Estimate {
        self.estimate_on(&self.device, first_seed, change)
    }

    fn estimate_on(&self, device: &Device, first_seed: u32, change: &dyn Fn(&mut Settings)) -> Estimate {
        let picture = |seed| {
            let mut settings = self.settings(Sampler::Bsdf, SamplePattern::Sobol, first_seed + seed);
            change(&mut settings);
            device.render(&self.scene, &settings, SPP)
        };
        of_spread(&(0..PICTURES).map(picture).collect::<Vec<_>>())
    }
}

/// Mean over pictures, and the variance of the mean.
fn of_spread(pictures: &[Picture]) -> Estimate {
    let count = pictures.len() as f64;
    let [width, height] = SIZE;
    let moments = |at: usize, channel: usize| {
        let values = || pictures.iter().map(|picture| f64::from(picture.radiance[at][channel]));
        let mean = values().sum::<f64>() / count;
        (mean, values().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0) / count)
    };
    let image = |value: &dyn Fn((f64, f64)) -> f64| {
        let pixel = |at| [0, 1, 2].map(|channel| value(moments(at, channel)) as f32);
        Image { width, height, pixels: (0..(width * height) as usize).map(pixel).collect() }
    };
    Estimate::new(&image(&|(mean, _)| mean), &image(&|(_, variance)| variance))
}

#[test]
fn all_patterns_give_the_same_picture() {
    if tier::is_skipped("the proofs' claim patterns") {
        return;
    }
    let studio = Studio::new();
    let (device, faulty) = (&studio.device, &studio.device.mutated(DENSITIES));
    for (sampler, seed) in [(Sampler::Bsdf, 0u32), (Sampler::Product, 1000)] {
        let estimate = |device, pattern, offset: u32| {
            studio.estimate_on(device, seed + offset, &|s| (s.sampler, s.pattern) = (sampler, pattern))
        };
        let independent = estimate(device, SamplePattern::Independent, 0);
        for pattern in SETS {
            let comparison = Comparison::new(&independent, &estimate(device, pattern, 100), &[12, WHOLE]);
            println!("{sampler:?}, {pattern:?}: {comparison:?}");
            assert!(comparison.agrees(), "{sampler:?}, {pattern:?}");
            let wrong = Comparison::new(&independent, &estimate(faulty, pattern, 200), &[12, WHOLE]);
            assert!(!wrong.agrees(), "{sampler:?}, {pattern:?}: a density 5 % wrong");
        }
    }
}

/// Sets leave less variance than independent samples. The quick tier has one pattern with sets.
#[test]
fn sets_leave_less_noise() {
    let studio = Studio::new();
    let variance = |pattern, first_seed| studio.estimate(first_seed, &|s| s.pattern = pattern).total_variance();
    let independent = variance(SamplePattern::Independent, 0);
    let relative = |pattern, first_seed| variance(pattern, first_seed) / independent;
    let sets: Vec<_> = tier::some_of(&SETS, 1).iter().map(|&pattern| relative(pattern, 100)).collect();
    let again = relative(SamplePattern::Independent, 300);
    println!("variance of sets {sets:.3?}, of independent samples of other seeds {again:.3}");
    assert!(sets.iter().all(|&sets| sets < 0.7) && again > 0.7);
}

/// Camera rays follow one sequence for all samples, even if a guide ends sets with each step. So edges that the camera
/// sees have less noise than sets would leave.
#[test]
fn camera_rays_leave_less_noise_than_sets_would() {
    if tier::is_skipped("sets_leave_less_noise") {
        return;
    }
    let studio = Studio::new();
    for sampler in [Sampler::Product, Sampler::Bsdf] {
        let variance = |pattern, first_seed| {
            // Paths of one edge see the light and its edges.
            let change = |s: &mut Settings| (s.sampler, s.pattern, s.max_depth) = (sampler, pattern, 1);
            studio.estimate(first_seed, &change).total_variance()
        };
        let independent = variance(SamplePattern::Independent, 0);
        let [sequence, again] = [(SamplePattern::Sobol, 100), (SamplePattern::Independent, 300)]
            .map(|(pattern, first_seed)| variance(pattern, first_seed) / independent);
        println!("{sampler:?}: variance of a sequence {sequence:.3}, of independent samples of other seeds {again:.3}");
        // The relative error of sets of eight would be 8^-0.5 = 0.35, that of 32 samples of a sequence 32^-0.5 = 0.18.
        assert!(sequence < 0.25 && again > 0.5, "{sampler:?}: {sequence} {again}");
    }
}

#[test]
fn sets_come_out_the_same_however_the_work_is_cut() {
    let studio = Studio::new();
    for (pattern, sampler) in
        SETS.into_iter().flat_map(|pattern| [(pattern, Sampler::Bsdf), (pattern, Sampler::Product)])
    {
        let render = |change: &dyn Fn(&mut Settings)| {
            let mut settings = studio.settings(sampler, pattern, 5);
            change(&mut settings);
            bits(&studio.device.render(&studio.scene, &settings, SPP))
        };
        let first = render(&|_| {});
        assert!(first == render(&|s| s.slice_milliseconds = Some(1.0)), "{pattern:?}, {sampler:?}: slices of 1 ms");
        assert!(first == render(&|s| s.film_page_pixels = Some(256)), "{pattern:?}, {sampler:?}: film pages");
        assert!(first != render(&|s| s.seed = 6), "{pattern:?}, {sampler:?}: another seed");
        assert!(
            first != render(&|s| s.pattern = SamplePattern::Independent),
            "{pattern:?}, {sampler:?}: independent samples"
        );
    }
}

/// Sets reach over steps where there is no guide. A part of a picture that begins within a set has the samples of the
/// whole picture.
#[test]
fn unguided_sets_do_not_depend_on_steps() {
    let studio = Studio::new();
    for pattern in SETS {
        let render = |spp_per_step, sample_offset, spp| {
            let plain = studio.settings(Sampler::Bsdf, pattern, 5);
            let picture = studio.device.render(&studio.scene, &Settings { spp_per_step, sample_offset, ..plain }, spp);
            picture.radiance.into_iter().flatten().map(f64::from).collect::<Vec<_>>()
        };
        let whole = render(8, None, 20);
        let [first, second] = [render(8, Some(0), 11), render(8, Some(11), 9)];
        let parts: Vec<_> = first.iter().zip(&second).map(|(a, b)| (11.0 * a + 9.0 * b) / 20.0).collect();
        for (a, others) in whole.iter().zip(render(STEP, None, 20).iter().zip(&parts)) {
            for b in [others.0, others.1] {
                assert!((a - b).abs() <= 1.0e-5 * a.abs().max(1.0e-3), "{pattern:?}: {a} {b}");
            }
        }
    }
}
