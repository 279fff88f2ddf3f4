//! What samples count for: a fixed schedule keeps pictures unbiased, measured variance nearly so; and both do what they say.

use lodestar::film::Picture;
use lodestar::renderer::RenderState;
use lodestar::scene::Scene;
use lodestar::settings::{SampleWeights, Sampler, Settings, StepSchedule};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::floor::floor_radiance;
use support::scenes::{ours, settings};
use support::significance::{ALPHA, two_sided};

use crate::determinism::bits;
use crate::device::{Device, steps};
use crate::variance::{ratio_and_deviation, spread_and_claim};

/// Not a whole number of tiles.
const SIZE: [u32; 2] = [60, 41];
/// Whole blocks of both kinds, and a part of one.
const ENDS: [u32; 5] = [0, 8, 16, 32, 40];
/// Largest relative bias by measured weights: 0.6 %, as simulated, and three standard errors of [`REPEATS`] pictures.
const MOST_BIAS: f64 = 0.02;
const REPEATS: u32 = 1000;

fn box_settings(scene: &Scene, size: [u32; 2], sample_weights: SampleWeights, seed: u32) -> Settings {
    Settings { sample_weights: Some(sample_weights), ..settings(scene, size, Sampler::Product, seed) }
}

/// As many samples of every pixel: by pixel and channel their mean and their squared deviations.
struct Block {
    samples: f64,
    mean: Vec<f64>,
    squared_deviation: Vec<f64>,
}

impl Block {
    fn of(picture: &Picture) -> Self {
        let samples = f64::from(picture.sample_count[0]);
        let doubles = |values: &[[f32; 3]]| values.iter().flatten().map(|&value| f64::from(value)).collect::<Vec<_>>();
        let variance = doubles(&picture.variance);
        let squared_deviation = variance.into_iter().map(|variance| variance * samples * (samples - 1.0)).collect();
        Self { samples, mean: doubles(&picture.radiance), squared_deviation }
    }

    /// Those of `self` that `first` has not.
    fn without(&self, first: &Self) -> Self {
        let samples = self.samples - first.samples;
        let mean = |at: usize| (self.samples * self.mean[at] - first.samples * first.mean[at]) / samples;
        let mean: Vec<_> = (0..self.mean.len()).map(mean).collect();
        let between = |at: usize| (mean[at] - first.mean[at]).powi(2) * first.samples * samples / self.samples;
        let squared = |at: usize| self.squared_deviation[at] - first.squared_deviation[at] - between(at);
        let squared_deviation = (0..mean.len()).map(squared).collect();
        Self { samples, mean, squared_deviation }
    }

    /// Mean variance of a sample of the pixels of one color of a chessboard, that of a pixel being 10^4 times the square of their
    /// mean radiance at most.
    fn variance(&self, half: usize) -> f64 {
        let pixels = || (0..self.mean.len() / 3).filter(|&pixel| half_of(3 * pixel) == half);
        let count = pixels().count() as f64;
        let sum = |values: &[f64], pixel: usize| values[3 * pixel..][..3].iter().sum::<f64>() / 3.0;
        let radiance = pixels().map(|pixel| sum(&self.mean, pixel)).sum::<f64>() / count;
        let variance = |pixel| sum(&self.squared_deviation, pixel) / (self.samples - 1.0);
        pixels().map(|pixel| variance(pixel).min(1.0e4 * radiance * radiance)).sum::<f64>() / count
    }
}

/// The color of the pixel on a chessboard.
fn half_of(at: usize) -> usize {
    let (x, y) = (at / 3 % SIZE[0] as usize, at / 3 / SIZE[0] as usize);
    (x + y) % 2
}

/// The blocks of a render that weighs all samples alike.
fn blocks(device: &Device, scene: &Scene) -> Vec<Block> {
    let settings = box_settings(scene, SIZE, SampleWeights::Even, 4);
    let mut renderer = device.renderer(scene, &settings);
    let mut until = |spp: u32| {
        steps(&mut renderer, &settings, spp);
        Block::of(&renderer.picture().expect("a picture"))
    };
    let sums: Vec<_> = ENDS[1..].iter().map(|&end| until(end)).collect();
    let first =
        Block { samples: 8.0, mean: sums[0].mean.clone(), squared_deviation: sums[0].squared_deviation.clone() };
    [first].into_iter().chain(sums.windows(2).map(|pair| pair[1].without(&pair[0]))).collect()
}

/// The mean of blocks whose samples have weights by pixel and channel.
fn weighed(blocks: &[Block], weight: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let of_pixel = |at: usize| {
        let terms = blocks.iter().enumerate().map(|(index, block)| (block.samples * weight(index, at), block.mean[at]));
        let (sum, total) = terms.fold((0.0, 0.0), |(sum, total), (weight, mean)| (sum + weight * mean, total + weight));
        sum / total
    };
    (0..blocks[0].mean.len()).map(of_pixel).collect()
}

/// The largest difference over the mean of the picture.
fn difference(picture: &Picture, expected: &[f64]) -> f64 {
    let mean = expected.iter().sum::<f64>() / expected.len() as f64;
    let pixels = picture.radiance.iter().flatten().zip(expected);
    pixels.map(|(&found, expected)| (f64::from(found) - expected).abs()).fold(0.0, f64::max) / mean
}

#[test]
fn pictures_are_the_means_that_weights_make() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    let blocks = blocks(&device, &scene);
    let render = |weights| device.render(&scene, &box_settings(&scene, SIZE, weights, 4), ENDS[4]);
    // The last samples, which are no block yet, count for what those of the block before do.
    let variances: Vec<_> = blocks.iter().map(|block| [0, 1].map(|half| block.variance(half))).collect();
    let even = weighed(&blocks, |_, _| 1.0);
    let growing = weighed(&blocks, |block, _| [0.5, 0.75, 1.0, 1.0][block]);
    let measured = weighed(&blocks, |block, at| 1.0 / variances[block.min(2)][1 - half_of(at)]);
    let own = weighed(&blocks, |block, at| 1.0 / variances[block.min(2)][half_of(at)]);
    for (weights, right, wrong) in [
        (SampleWeights::Even, &even, &growing),
        (SampleWeights::Growing, &growing, &even),
        (SampleWeights::Measured, &measured, &own),
    ] {
        let picture = render(weights);
        let [right, wrong] = [right, wrong].map(|expected| difference(&picture, expected));
        println!("{weights:?}: {right:.1e}, the twin {wrong:.1e}");
        assert!(right < 1.0e-4 && wrong > 1.0e-3, "{weights:?}");
    }
}

#[test]
fn a_schedule_leaves_no_bias() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    let plain = settings(&scene, [32, 32], Sampler::Bsdf, 1);
    let plain = Estimate::of(&device.render(&scene, &plain, 8192));
    let compare = |seed, pdf_tamper| {
        let settings = Settings { pdf_tamper, ..box_settings(&scene, [32, 32], SampleWeights::Growing, seed) };
        // So many short renders as have as many samples: most of them are of low weight.
        let pictures: Vec<_> =
            (0..32).map(|i| device.render(&scene, &Settings { seed: seed + i, ..settings.clone() }, 32)).collect();
        let comparison = Comparison::new(&plain, &mean_of(&pictures), &[8, WHOLE]);
        println!("densities times {pdf_tamper}: {comparison:?}");
        comparison.agrees()
    };
    assert!(compare(100, 1.0) && !compare(200, 1.05));
}

/// Of pictures of as many samples.
fn mean_of(pictures: &[Picture]) -> Estimate {
    let mut mean = pictures[0].clone();
    let count = pictures.len() as f32;
    for at in 0..mean.radiance.len() {
        for c in 0..3 {
            mean.radiance[at][c] = pictures.iter().map(|picture| picture.radiance[at][c]).sum::<f32>() / count;
            mean.variance[at][c] = pictures.iter().map(|picture| picture.variance[at][c]).sum::<f32>() / count / count;
        }
    }
    Estimate::of(&mean)
}

/// A floor under a lamp that one path in seventy meets, whatever the guide: relative bias over many pictures.
fn bias_of_rare_hits(own_weights: bool) -> f64 {
    let device = Device::new();
    let scene = ours("lights/floor.xml", &[("light", "sphere")]);
    let settings = Settings {
        epsilon: Some(1.0),
        max_depth: 2,
        grid: 1,
        steps: StepSchedule::Even,
        own_weights,
        ..box_settings(&scene, [8, 8], SampleWeights::Measured, 9)
    };
    let mut renderer = device.renderer(&scene, &settings);
    let empty = renderer.state().expect("a state");
    let mut total = 0.0;
    for repeat in 0..REPEATS {
        // Other samples of an empty film.
        let state = RenderState { samples_done: 64 * repeat, ..empty.clone() };
        renderer.restore(&state).expect("the same settings");
        for samples in [8, 8, 16, 32] {
            assert!(renderer.step(samples, &|| false).expect("a step").complete);
        }
        total += Estimate::of(&renderer.picture().expect("a picture")).gray().0;
    }
    total / f64::from(REPEATS) / floor_radiance("sphere") - 1.0
}

#[test]
fn measured_weights_hardly_bias_rare_hits() {
    let [crossed, own] = [false, true].map(bias_of_rare_hits);
    println!("relative bias {crossed:+.4}, by their own variance {own:+.4}");
    assert!(crossed.abs() < MOST_BIAS && own.abs() > MOST_BIAS);
}

#[test]
fn the_variance_layer_is_that_of_the_weighed_mean() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    for (weights, spp) in [(SampleWeights::Growing, 20), (SampleWeights::Measured, 33)] {
        let picture = |seed: u32| device.render(&scene, &box_settings(&scene, [32, 32], weights, 500 + seed), spp);
        let pixels = spread_and_claim(&(0..32).map(picture).collect::<Vec<_>>());
        for (fault, is_right) in [(1.0, true), (1.3, false), (1.0 / 1.3, false)] {
            let (ratio, z) = ratio_and_deviation(&pixels, fault);
            println!("{weights:?} claims x {fault:.2}: spread / claim = {ratio:.4}, z = {z:.2}");
            assert_eq!(two_sided(z) > ALPHA, is_right, "{weights:?} {fault}");
        }
    }
}

/// Neither pages nor slices nor a break, within a block or at its end, change a bit.
#[test]
fn weighed_renders_go_on_with_the_same_bits() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    for weights in [SampleWeights::Growing, SampleWeights::Measured] {
        let settings = box_settings(&scene, SIZE, weights, 4);
        let picture = |renderer: &lodestar::renderer::Renderer| bits(&renderer.picture().expect("a picture"));
        let mut renderer = device.renderer(&scene, &settings);
        steps(&mut renderer, &settings, 44);
        let whole = picture(&renderer);
        for (spp, pages, slice) in [(8, Some(256), None), (24, None, Some(1.0)), (40, Some(512), Some(5.0))] {
            let cut = Settings { film_page_pixels: pages, slice_milliseconds: slice, ..settings.clone() };
            let mut renderer = device.renderer(&scene, &cut);
            steps(&mut renderer, &cut, spp);
            let state = renderer.state().expect("a state");
            let mut renderer = device.renderer(&scene, &settings);
            renderer.restore(&state).expect("the same settings");
            assert!(renderer.state().expect("a state") == state, "{weights:?} {spp}");
            steps(&mut renderer, &settings, 44);
            assert!(picture(&renderer) == whole, "{weights:?} {spp}");
        }
        let even = device.render(&scene, &box_settings(&scene, SIZE, SampleWeights::Even, 4), 44);
        assert!(bits(&even) != whole, "{weights:?}: the twin");
    }
}
