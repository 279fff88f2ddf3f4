//! Comparison of as many samples with a guide as without, in the number that `LODESTAR_SAMPLES` gives:
//! `LODESTAR_SAMPLES=1e9 cargo test --release --test proofs -- --nocapture billion`. Without the variable, nothing is
//! tested.

use std::env;
use std::io::{Write, stdout};
use std::time::Instant;

use lodestar::encode::bvh::Bvh;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::renderer::Renderer;
use lodestar::settings::{SamplePattern, Sampler, Settings};
use support::estimate::Estimate;
use support::scenes::ours;

const WIDTH: u32 = 256;
const HEIGHT: u32 = 144;
/// Number of intermediate results that a run prints, including the last one.
const REPORTS: u32 = 20;
/// Maximum distance between the two means, in standard errors.
const MOST_SIGMA: f64 = 4.0;

/// Mean radiance over all pixels and channels, and an upper bound of its standard error.
type Mean = (f64, f64);

/// Difference of the second mean from the first, with its standard error.
struct Verdict {
    difference: f64,
    error: f64,
    relative_to: f64,
}

impl Verdict {
    fn new((unguided, unguided_error): Mean, (guided, guided_error): Mean) -> Self {
        let error = unguided_error.hypot(guided_error);
        Self { difference: guided - unguided, error, relative_to: unguided }
    }

    fn sigma(&self) -> f64 {
        self.difference / self.error
    }

    fn relative_difference(&self) -> f64 {
        self.difference / self.relative_to
    }

    /// Upper bound of the relative bias: the difference that was found plus `MOST_SIGMA` standard errors.
    fn bound(&self) -> f64 {
        (self.difference.abs() + MOST_SIGMA * self.error) / self.relative_to
    }
}

fn wanted_samples() -> Option<f64> {
    let text = env::var("LODESTAR_SAMPLES").ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("LODESTAR_SAMPLES is `{text}`, but must be a number, such as 1e9")))
}

fn report(renderers: &[Renderer; 2], begin: Instant) -> Verdict {
    let means = renderers.each_ref().map(|renderer| Estimate::of(&renderer.picture().expect("a picture")).gray());
    let verdict = Verdict::new(means[0], means[1]);
    let samples = u64::from(renderers[1].samples_done()) * u64::from(WIDTH * HEIGHT);
    println!(
        "{samples} samples each after {:.0} s: bsdf {:.7} +- {:.7}, rejection-mix {:.7} +- {:.7}; \
         relative difference {:+.2e}, {:+.2} standard errors; relative bias below {:.2e}",
        begin.elapsed().as_secs_f64(),
        means[0].0,
        means[0].1,
        means[1].0,
        means[1].1,
        verdict.relative_difference(),
        verdict.sigma(),
        verdict.bound()
    );
    stdout().flush().expect("standard output");
    verdict
}

/// The means of many samples with and without a guide differ by less than `MOST_SIGMA` standard errors. Both renderers
/// take steps in turn, so that both have as many samples whenever the test is stopped. Samples of different steps are
/// uncorrelated, whatever the guide has learned before: the expectation of each step is the same.
#[test]
fn billion() {
    let Some(samples) = wanted_samples() else {
        return println!("skipped: LODESTAR_SAMPLES is not set; in small: the claim pictures");
    };
    let context = Context::new(&ContextOptions { device: None, validate: false }).expect("a Vulkan device");
    let scene = ours("door-ajar/scene.xml", &[]);
    let bvh = Bvh::of_scene(&scene);
    let settings = |sampler, seed| Settings {
        width: WIDTH,
        height: HEIGHT,
        sampler,
        seed,
        nee: false,
        pattern: SamplePattern::Independent,
        ..Settings::for_scene(&scene)
    };
    let settings = [settings(Sampler::Bsdf, 101), settings(Sampler::RejectionMix, 202)];
    let mut renderers =
        settings.each_ref().map(|settings| Renderer::new(&context, &scene, &bvh, settings).expect("a renderer"));
    let steps = (samples / f64::from(WIDTH * HEIGHT * settings[0].spp_per_step)).ceil().max(2.0) as u32;
    println!("{}, seeds {} and {}, {steps} steps", context.device().name, settings[0].seed, settings[1].seed);
    let begin = Instant::now();
    let mut verdict = None;
    for step in 1..=steps {
        for (renderer, settings) in renderers.iter_mut().zip(&settings) {
            let report = renderer.step(settings.spp_per_step, &|| false).expect("a step");
            assert_eq!((report.counts.nonfinite, report.counts.overruns), (0, 0));
        }
        let reports = |step: u32| u64::from(step) * u64::from(REPORTS) / u64::from(steps);
        if reports(step) > reports(step - 1) {
            verdict = Some(report(&renderers, begin));
        }
    }
    let verdict = verdict.expect("the last step reports");
    assert!(verdict.sigma().abs() < MOST_SIGMA, "{} standard errors apart", verdict.sigma());
}

#[test]
fn the_verdict_on_two_means_is_their_difference_in_standard_errors() {
    let verdict = Verdict::new((2.0, 0.003), (2.01, 0.004));
    assert!((verdict.sigma() - 2.0).abs() < 1.0e-9 && (verdict.bound() - 0.015).abs() < 1.0e-9);
    // The twin must fail: a guide that is 2 % off.
    assert!(Verdict::new((2.0, 0.003), (2.04, 0.004)).sigma() > MOST_SIGMA);
}
