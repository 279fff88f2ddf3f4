//! Renders that end by noise: their error against the requested error, and the distribution of their samples.

use std::sync::OnceLock;

use lodestar::film::Picture;
use lodestar::film::noise::{LEAST_SAMPLES, TileNoise, Tiles};
use lodestar::renderer::{RenderState, Renderer};
use lodestar::scene::Scene;
use lodestar::settings::{SamplePattern, SampleWeights, Sampler, Settings};
use support::scenes::{ours, settings};
use support::tier;

use crate::determinism::bits;
use crate::device::Device;

/// Size that is not a whole number of tiles.
const SIZE: [u32; 2] = [44, 41];
/// Pixels along each side of a tile.
const TILE: u32 = 8;
const TARGET: f32 = 0.1;
/// Maximum number of samples per pixel, more than any tile of the scene needs.
const MOST: u32 = 1 << 14;

struct Studio {
    device: Device,
    scene: Scene,
}

impl Studio {
    fn new() -> Self {
        Self { device: Device::new(), scene: ours("cornell-box/scene.xml", &[]) }
    }

    /// Settings of a guide that does not borrow. One that does needs no more than the least number of samples here.
    fn settings(&self, noise: Option<f32>) -> Settings {
        let (sample_weights, fallback) = (Some(SampleWeights::Even), Some(0.0));
        Settings { noise, sample_weights, fallback, nee: true, ..settings(&self.scene, SIZE, Sampler::Product, 5) }
    }

    fn renderer(&self, settings: &Settings) -> Renderer {
        self.device.renderer(&self.scene, settings)
    }

    /// Picture of a render that runs until `target` is reached.
    fn render(&self, target: f32) -> Picture {
        let mut renderer = self.renderer(&self.settings(Some(target)));
        while renderer.sampled_pixels() > 0 {
            step(&mut renderer);
            assert!(renderer.samples_done() < MOST, "{:?}", renderer.noise());
        }
        renderer.picture().expect("a picture")
    }

    /// Picture with a tenth of the requested error, or a fifth in the quick tier. It is rendered once.
    fn truth(&self) -> &'static Picture {
        static TRUTH: OnceLock<Picture> = OnceLock::new();
        let settings = Settings { sampler: Sampler::Bsdf, seed: 77, spp_per_step: 64, ..self.settings(None) };
        let spp = if tier::is_full() { 8192 } else { 2048 };
        TRUTH.get_or_init(|| self.device.render(&self.scene, &settings, spp))
    }
}

fn step(renderer: &mut Renderer) {
    let report = renderer.step(renderer.samples_of_next_step(), &|| false).expect("a step");
    assert!(report.complete);
}

fn tiles() -> Tiles {
    Tiles::new(SIZE[0], SIZE[1], TILE)
}

fn mean_rgb(color: [f32; 3]) -> f64 {
    color.into_iter().map(f64::from).sum::<f64>() / 3.0
}

/// Indices of the pixels of a tile that lie within the picture.
fn pixels_of(tile: usize) -> Vec<usize> {
    let [width, height] = SIZE;
    let columns = width.div_ceil(TILE);
    let (x, y) = (tile as u32 % columns * TILE, tile as u32 / columns * TILE);
    let rows = y..(y + TILE).min(height);
    rows.flat_map(|y| (x..(x + TILE).min(width)).map(move |x| (y * width + x) as usize)).collect()
}

/// Relative error of every tile against `truth`, defined in the same way as the estimate.
fn true_errors(picture: &Picture, truth: &Picture) -> Vec<f64> {
    let noise = |tile: usize| {
        let pixels = pixels_of(tile);
        let radiance: f64 = pixels.iter().map(|&at| mean_rgb(truth.radiance[at])).sum();
        let of_tile = radiance / pixels.len() as f64;
        let squared_error = |&at: &usize| {
            let difference = [0, 1, 2].map(|c| (picture.radiance[at][c] - truth.radiance[at][c]).powi(2));
            mean_rgb(difference) / mean_rgb(truth.radiance[at]).max(of_tile).powi(2)
        };
        TileNoise { squared_error: pixels.iter().map(squared_error).sum(), radiance }
    };
    tiles().relative_errors(&(0..tiles().count()).map(noise).collect::<Vec<_>>())
}

fn root_mean_square(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Whether a picture has about the requested error: at most 1.1 times and at least half of it over all tiles, and at
/// most twice in a single tile.
fn is_as_asked(errors: &[f64], target: f64) -> bool {
    (0.5 * target..1.1 * target).contains(&root_mean_square(errors)) && errors.iter().all(|&error| error < 2.0 * target)
}

#[test]
fn the_error_that_is_asked_for_is_reached() {
    let studio = Studio::new();
    let truth = studio.truth();
    let errors = true_errors(&studio.render(TARGET), truth);
    println!("{:.4}, the largest {:.4}", root_mean_square(&errors), errors.iter().copied().fold(0.0, f64::max));
    assert!(is_as_asked(&errors, TARGET.into()));
    let too_noisy = true_errors(&studio.render(2.0 * TARGET), truth);
    assert!(!is_as_asked(&too_noisy, TARGET.into()), "{:.4}", root_mean_square(&too_noisy));
    if tier::is_full() {
        let too_good = true_errors(&studio.render(0.4 * TARGET), truth);
        assert!(!is_as_asked(&too_good, TARGET.into()), "{:.4}", root_mean_square(&too_good));
    }
}

/// Estimated errors are right for every pattern. Samples of a set depend on each other, but the two halves that an
/// estimate compares must not. The quick tier has one pattern.
#[test]
fn estimates_are_right_for_every_pattern() {
    let studio = Studio::new();
    let is_right = |estimate: f64, error: f64| (0.85..1.15).contains(&(estimate / error));
    let patterns = [SamplePattern::Sobol, SamplePattern::Independent, SamplePattern::BlueNoise];
    for &pattern in tier::some_of(&patterns, 1) {
        let settings = Settings { pattern, ..studio.settings(Some(1.0e-4)) };
        let mut renderer = studio.renderer(&settings);
        while renderer.samples_done() < 128 {
            step(&mut renderer);
        }
        let estimate = renderer.noise().and_then(|noise| noise.mean).expect("an estimate");
        let picture = renderer.picture().expect("a picture");
        let error = root_mean_square(&true_errors(&picture, studio.truth()));
        println!("{pattern:?}: {estimate:.4} by estimate, {error:.4}");
        assert!(is_right(estimate, error), "{pattern:?}");
        // The twins must fail: errors for half as many samples, and for twice as many.
        assert!(!is_right(estimate * f64::sqrt(2.0), error) && !is_right(estimate / f64::sqrt(2.0), error));
    }
}

/// Neighbors of a tile, including itself.
fn around(tile: usize) -> impl Iterator<Item = usize> {
    let [columns, rows] = SIZE.map(|size| size.div_ceil(TILE) as usize);
    let (column, row) = (tile % columns, tile / columns);
    let range = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
    range(row, rows).flat_map(move |y| range(column, columns).map(move |x| y * columns + x))
}

#[test]
fn samples_go_where_they_are_needed() {
    let mut studio = Studio::new();
    // Half of the picture shows the empty space beside the box, where estimates have no error.
    studio.scene.camera.principal_point.x += 0.5;
    let picture = studio.render(TARGET);
    let is_lit = |tile: usize| pixels_of(tile).iter().any(|&at| mean_rgb(picture.radiance[at]) > 0.0);
    let (mut dark_tiles, mut lit_tiles) = (0, 0);
    for tile in 0..tiles().count() {
        let pixels = pixels_of(tile);
        let samples = picture.sample_count[pixels[0]];
        assert!(pixels.iter().all(|&at| picture.sample_count[at] == samples), "a tile has as many everywhere");
        if around(tile).all(is_lit) {
            assert!(samples > LEAST_SAMPLES, "tile {tile}: {samples}");
            lit_tiles += 1;
        } else if !around(tile).any(is_lit) {
            assert_eq!(samples, LEAST_SAMPLES, "tile {tile}");
            dark_tiles += 1;
        }
    }
    assert!(lit_tiles >= 6 && dark_tiles >= 6, "{lit_tiles} and {dark_tiles}");
}

/// A target out of reach changes no bit: judging noise does not affect the picture.
#[test]
fn a_target_out_of_reach_changes_no_bit() {
    let studio = Studio::new();
    let render = |noise| {
        let mut renderer = studio.renderer(&studio.settings(noise));
        while renderer.samples_done() < 64 {
            step(&mut renderer);
        }
        bits(&renderer.picture().expect("a picture"))
    };
    let plain = render(None);
    assert!(render(Some(1.0e-4)) == plain);
    assert!(render(Some(0.3)) != plain, "tiles end before");
}

/// Pages, slices and interruptions change no bit, also where few tiles are left and steps are long.
#[test]
fn the_same_seed_ends_with_the_same_bits() {
    let studio = Studio::new();
    let settings = studio.settings(Some(TARGET));
    let rest = |mut renderer: Renderer| {
        let mut longest = 0;
        while renderer.sampled_pixels() > 0 {
            longest = longest.max(renderer.samples_of_next_step());
            step(&mut renderer);
        }
        (bits(&renderer.picture().expect("a picture")), renderer.samples_done(), longest)
    };
    let whole = rest(studio.renderer(&settings));
    assert!(whole.2 > settings.spp_per_step, "no step was longer than usual");
    let cuts = [(Some(512), Some(5.0), 0.1), (Some(256), None, 0.99), (None, Some(1.0), 0.5)];
    for &(pages, slice, share) in tier::some_of(&cuts, 1) {
        let cut = Settings { film_page_pixels: pages, slice_milliseconds: slice, ..settings.clone() };
        assert!(rest(studio.renderer(&cut)) == whole, "{pages:?}, {slice:?}");
        let mut renderer = studio.renderer(&cut);
        while renderer.noise().expect("noise").sampled_share > share {
            step(&mut renderer);
        }
        let state: RenderState = renderer.state().expect("a state");
        let mut renderer = studio.renderer(&settings);
        renderer.restore(&state).expect("the same settings");
        assert!(renderer.state().expect("a state") == state, "{pages:?}");
        assert!(rest(renderer).0 == whole.0, "{pages:?}, {slice:?}, {share}");
    }
}
