//! Sample weights: a fixed schedule keeps pictures unbiased and has the weights that it promises.

use lodestar::film::Picture;
use lodestar::scene::Scene;
use lodestar::settings::{SampleWeights, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::mutated::DENSITIES;
use support::scenes::{ours, settings};
use support::significance::{ALPHA, two_sided};
use support::tier;

use crate::determinism::bits;
use crate::device::{Device, steps};
use crate::variance::{ratio_and_deviation, spread_and_claim};

/// Size that is not a whole number of tiles.
const SIZE: [u32; 2] = [60, 41];
/// Ends of the schedule's blocks, and of a part of a block.
const ENDS: [u32; 5] = [0, 8, 16, 32, 40];

fn box_settings(scene: &Scene, size: [u32; 2], sample_weights: SampleWeights, seed: u32) -> Settings {
    Settings { sample_weights: Some(sample_weights), ..settings(scene, size, Sampler::Product, seed) }
}

/// Block of equally many samples of every pixel: their number, and their mean by pixel and channel.
struct Block {
    samples: f64,
    mean: Vec<f64>,
}

impl Block {
    fn of(picture: &Picture) -> Self {
        let samples = f64::from(picture.sample_count[0]);
        Self { samples, mean: picture.radiance.iter().flatten().map(|&value| f64::from(value)).collect() }
    }

    /// Block of the samples of `self` that are not in `first`.
    fn without(&self, first: &Self) -> Self {
        let samples = self.samples - first.samples;
        let mean = |at: usize| (self.samples * self.mean[at] - first.samples * first.mean[at]) / samples;
        Self { samples, mean: (0..self.mean.len()).map(mean).collect() }
    }
}

/// Blocks of a render with equal sample weights.
fn blocks(device: &Device, scene: &Scene) -> Vec<Block> {
    let settings = box_settings(scene, SIZE, SampleWeights::Even, 4);
    let mut renderer = device.renderer(scene, &settings);
    let mut until = |spp: u32| {
        steps(&mut renderer, &settings, spp);
        Block::of(&renderer.picture().expect("a picture"))
    };
    let sums: Vec<_> = ENDS[1..].iter().map(|&end| until(end)).collect();
    let first = Block { samples: 8.0, mean: sums[0].mean.clone() };
    [first].into_iter().chain(sums.windows(2).map(|pair| pair[1].without(&pair[0]))).collect()
}

/// Weighted mean of the blocks.
fn weighted(blocks: &[Block], weights: [f64; 4]) -> Vec<f64> {
    let of_pixel = |at: usize| {
        let terms = blocks.iter().zip(weights).map(|(block, weight)| (block.samples * weight, block.mean[at]));
        let (sum, total) = terms.fold((0.0, 0.0), |(sum, total), (weight, mean)| (sum + weight * mean, total + weight));
        sum / total
    };
    (0..blocks[0].mean.len()).map(of_pixel).collect()
}

/// Largest difference between picture and `expected`, relative to the mean of `expected`.
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
    let even = weighted(&blocks, [1.0; 4]);
    let growing = weighted(&blocks, [0.5, 0.75, 1.0, 1.0]);
    for (weights, right, wrong) in [(SampleWeights::Even, &even, &growing), (SampleWeights::Growing, &growing, &even)] {
        let picture = render(weights);
        let [right, wrong] = [right, wrong].map(|expected| difference(&picture, expected));
        println!("{weights:?}: {right:.1e}, the twin {wrong:.1e}");
        assert!(right < 1.0e-4 && wrong > 1.0e-3, "{weights:?}");
    }
}

#[test]
fn a_schedule_leaves_no_bias() {
    if tier::is_skipped("the row `product, growing weights` of the proofs' claim pictures") {
        return;
    }
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    let plain = settings(&scene, [32, 32], Sampler::Bsdf, 1);
    let plain = Estimate::of(&device.render(&scene, &plain, 8192));
    let compare = |seed, device: &Device| {
        let settings = box_settings(&scene, [32, 32], SampleWeights::Growing, seed);
        // Many short renders, because most of their samples have low weights.
        let pictures: Vec<_> =
            (0..32).map(|i| device.render(&scene, &Settings { seed: seed + i, ..settings.clone() }, 32)).collect();
        let comparison = Comparison::new(&plain, &mean_of(&pictures), &[8, WHOLE]);
        println!("{}: {comparison:?}", device.mutation());
        comparison.agrees()
    };
    assert!(compare(100, &device) && !compare(200, &device.mutated(DENSITIES)));
}

/// Mean of pictures with equal numbers of samples, with its variance.
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

#[test]
fn the_variance_layer_is_that_of_the_weighted_mean() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    let picture =
        |seed: u32| device.render(&scene, &box_settings(&scene, [32, 32], SampleWeights::Growing, 500 + seed), 20);
    let pixels = spread_and_claim(&(0..64).map(picture).collect::<Vec<_>>());
    for (fault, is_right) in [(1.0, true), (1.3, false), (1.0 / 1.3, false)] {
        let (ratio, z) = ratio_and_deviation(&pixels, fault);
        println!("claims x {fault:.2}: spread / claim = {ratio:.4}, z = {z:.2}");
        assert_eq!(two_sided(z) > ALPHA, is_right, "{fault}");
    }
}

/// Pages, slices and interruptions, within a block or at its end, change no bit.
#[test]
fn weighted_renders_go_on_with_the_same_bits() {
    let device = Device::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    let settings = box_settings(&scene, SIZE, SampleWeights::Growing, 4);
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
        assert!(renderer.state().expect("a state") == state, "{spp}");
        steps(&mut renderer, &settings, 44);
        assert!(picture(&renderer) == whole, "{spp}");
    }
    let even = device.render(&scene, &box_settings(&scene, SIZE, SampleWeights::Even, 4), 44);
    assert!(bits(&even) != whole, "the twin");
}
