//! Noise of blurred pictures: the noise that remains when a picture is seen from afar.

use lodestar::film::Picture;
use lodestar::settings::{SamplePattern, Sampler, Settings};
use support::scenes::{ours, settings};
use support::tier;

use crate::device::Device;

/// Pixels along each side of a picture, which has four tiles.
const SIDE: usize = 64;
const PICTURES: u32 = 8;
/// Standard deviation of the Gaussian blur, in pixels.
const BLUR: f64 = 1.5;
/// Reach of the blur to either side, in pixels.
const REACH: usize = 5;

/// Errors of every pixel of pictures with different seeds. The mean of the pictures stands for the truth. Errors are
/// relative to the pixel's own standard deviation, so all pixels count the same.
fn errors(pictures: &[Picture]) -> Vec<Vec<f64>> {
    let gray = |picture: &Picture| picture.radiance.iter().map(|pixel| f64::from(pixel.iter().sum::<f32>())).collect();
    let mut errors: Vec<Vec<f64>> = pictures.iter().map(gray).collect();
    for at in 0..SIDE * SIDE {
        let mean = errors.iter().map(|error| error[at]).sum::<f64>() / errors.len() as f64;
        errors.iter_mut().for_each(|error| error[at] -= mean);
        let deviation = (errors.iter().map(|error| error[at].powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
        errors.iter_mut().for_each(|error| error[at] /= deviation.max(f64::MIN_POSITIVE));
    }
    errors
}

/// Variance after a blur, relative to the variance after a blur of independent pixels.
fn left(pictures: &[Picture]) -> f64 {
    let (mut near, mut far) = (0.0, 0.0);
    for error in errors(pictures) {
        for (x, y) in inner().flat_map(|y| inner().map(move |x| (x, y))) {
            near += error[y * SIDE + x].powi(2);
            far += blurred(&error, x, y).powi(2);
        }
    }
    let of_independent = (0..=2 * REACH).map(|at| weight(at).powi(2)).sum::<f64>().powi(2);
    far / near / of_independent
}

/// Positions whose blur stays within the picture.
fn inner() -> std::ops::Range<usize> {
    REACH..SIDE - REACH
}

fn blurred(values: &[f64], x: usize, y: usize) -> f64 {
    let row =
        |j: usize| (0..=2 * REACH).map(|i| weight(i) * values[(y + j - REACH) * SIDE + x + i - REACH]).sum::<f64>();
    (0..=2 * REACH).map(|j| weight(j) * row(j)).sum()
}

/// Weight of the blur at the position `at` of its window. The middle of the window is `REACH`.
fn weight(at: usize) -> f64 {
    let density = |at: usize| (-0.5 * ((at as f64 - REACH as f64) / BLUR).powi(2)).exp();
    density(at) / (0..=2 * REACH).map(density).sum::<f64>()
}

/// Blurred pictures have less noise than independent pixels would leave. `--nocapture` prints the figures.
#[test]
fn neighbors_make_up_for_what_a_pixel_errs() {
    let (device, scene) = (Device::new(), ours("cornell-box/scene.xml", &[]));
    let left = |pattern, sampler, max_depth, spp_per_step, spp| {
        let picture = |seed| {
            let plain = settings(&scene, [SIDE as u32; 2], sampler, seed);
            let settings = Settings { pattern, nee: true, max_depth, spp_per_step, ..plain };
            device.render(&scene, &settings, spp)
        };
        left(&(0..PICTURES).map(picture).collect::<Vec<_>>())
    };
    // Sampler, edges of a path, samples per step, all samples, and the maximum variance after the blur. Light over many
    // edges depends on many random numbers, of which only pairs are well distributed.
    let cases = [
        (Sampler::Bsdf, 2, 8, 1, 0.7),
        (Sampler::Bsdf, 16, 8, 1, 0.9),
        (Sampler::Bsdf, 2, 8, 8, 0.7),
        (Sampler::Product, 2, 1, 8, 0.7),
        (Sampler::Bsdf, 16, 8, 8, 0.9),
    ];
    for &(sampler, max_depth, per_step, spp, most) in tier::some_of(&cases, 2) {
        let [sobol, blue] = [SamplePattern::Sobol, SamplePattern::BlueNoise]
            .map(|pattern| left(pattern, sampler, max_depth, per_step, spp));
        let case = format!("{sampler:?}, {max_depth} edges, {spp} samples in steps of {per_step}");
        println!("{case}: a blur leaves {blue:.2} of blue noise, {sobol:.2} of that of sobol");
        assert!(blue < most && sobol > most, "{case}");
    }
}
