//! Means of small pictures against closed forms.

use lodestar::scene::Scene;
use lodestar::settings::{Sampler, Settings};
use support::estimate::Estimate;
use support::scenes::settings;
use support::significance::{ALPHA, sidak, two_sided};

use crate::device::Device;

/// Number of the tests of closed forms in a file.
const TESTS: usize = 64;

/// Gray mean of a picture of 16 x 16 pixels, and its standard error.
pub fn mean_of(device: &Device, scene: &Scene, seed: u32, spp: u32, change: impl FnOnce(&mut Settings)) -> (f64, f64) {
    let mut settings = Settings { nee: true, ..settings(scene, [16, 16], Sampler::Bsdf, seed) };
    change(&mut settings);
    let found = Estimate::of(&device.render(scene, &settings, spp)).gray();
    println!("{:?} {:?}: {:.6} +- {:.6}", settings.sampler, settings.execution, found.0, found.1);
    found
}

/// Probability of so large a deviation from what is expected.
pub fn surprise((mean, error): (f64, f64), expected: f64) -> f64 {
    sidak(two_sided((mean - expected) / error.hypot(2.0e-5 * expected)), TESTS)
}

/// Fails unless the mean is as expected, and could be told from one that is 5 % larger.
#[track_caller]
pub fn assert_is(name: &str, rendered: (f64, f64), expected: f64) {
    println!("{name}: {rendered:?}, expected {expected:.6}");
    assert!(surprise(rendered, expected) > ALPHA, "{name}: {rendered:?}, not {expected}");
    assert!(surprise(rendered, 1.05 * expected) < ALPHA, "{name}: the twin, {rendered:?}");
}
