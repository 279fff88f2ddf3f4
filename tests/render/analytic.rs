//! The furnace, of which the answer is known.

use lodestar::renderer::Renderer;
use lodestar::settings::{Sampler, Settings};

use crate::device::{Device, steps};
use crate::estimate::Estimate;
use crate::scenes::{SAMPLERS, ours, settings};
use crate::significance::{ALPHA, sidak, two_sided};

const SIZE: [u32; 2] = [32, 32];
const SPP: u32 = 64;
/// What at most `n` edges see.
const fn answer(edges: u32) -> f64 {
    1.0 - 1.0 / (1_u64 << edges) as f64
}

/// Deviation of the mean radiance from the known answer, in standard errors.
fn deviation(device: &Device, file: &str, defines: &[(&str, &str)], change: impl FnOnce(&mut Settings)) -> f64 {
    let scene = ours(file, defines);
    let mut settings = settings(&scene, SIZE, Sampler::Bsdf, 5);
    change(&mut settings);
    let depth = settings.max_depth;
    let (mean, error) = Estimate::of(&device.render(&scene, &settings, SPP)).gray();
    // Single precision sums up 64 samples.
    let rounding = 1.0e-6;
    let z = (mean - answer(depth)) / error.hypot(rounding);
    println!("{file} {defines:?} {:?}: {mean:.6} +- {error:.6}, z = {z:.2}", settings.sampler);
    z
}

/// Cases: the sphere and its mesh, both samplers, roulette late and early.
#[test]
fn every_sampler_is_within_its_confidence_interval() {
    let device = Device::new();
    let files = ["furnace/scene.xml", "furnace/mesh.xml"];
    let cases: Vec<_> =
        files.iter().flat_map(|&file| SAMPLERS.map(|sampler| [2, 8].map(|rr| (file, sampler, rr)))).flatten().collect();
    for &(file, sampler, rr_depth) in &cases {
        let set = |s: &mut Settings| (s.sampler, s.rr_depth) = (sampler, rr_depth);
        let z = deviation(&device, file, &[], set);
        assert!(sidak(two_sided(z), cases.len()) > ALPHA, "{file} {sampler:?} roulette {rr_depth}: z = {z}");
    }
}

#[test]
fn a_wrong_density_or_albedo_is_found_in_the_furnace() {
    let device = Device::new();
    for sampler in SAMPLERS {
        let tampered = |s: &mut Settings| (s.sampler, s.pdf_tamper) = (sampler, 1.05);
        for (albedo, z) in [
            ("0.5", deviation(&device, "furnace/scene.xml", &[], tampered)),
            ("0.515", deviation(&device, "furnace/scene.xml", &[("albedo", "0.515")], |s| s.sampler = sampler)),
        ] {
            assert!(sidak(two_sided(z), 8) < ALPHA, "{sampler:?} with albedo {albedo}: z = {z}");
        }
    }
}

/// Without roulette the BSDF sampler has no noise here: every path sees the same.
#[test]
fn depth_counts_edges() {
    let device = Device::new();
    for (max_depth, hide_emitters) in [(1, false), (2, false), (3, false), (16, false), (1, true), (2, true), (3, true)]
    {
        let scene = ours("furnace/mesh.xml", &[]);
        let settings =
            Settings { max_depth, hide_emitters, rr_depth: 1000, ..settings(&scene, [16, 8], Sampler::Bsdf, 1) };
        let picture = device.render(&scene, &settings, 8);
        let expected = answer(max_depth) - if hide_emitters { 0.5 } else { 0.0 };
        let worst = picture.radiance.iter().flatten().map(|&l| (f64::from(l) - expected).abs()).fold(0.0, f64::max);
        assert!(worst < 2.0e-6, "depth {max_depth}, hidden {hide_emitters}: off by {worst}");
    }
}

/// Bins that have learned something (others are lifted to a 64th of their cell's mean).
fn learned_bins(renderer: &Renderer) -> Vec<f64> {
    renderer.radiance().expect("a table").into_iter().map(f64::from).filter(|&l| l > 0.2).collect()
}

fn mean_and_deviation(values: &[f64], expected: f64) -> (f64, f64) {
    let n = values.len() as f64;
    let squared: f64 = values.iter().map(|value| (value - expected).powi(2)).sum();
    (values.iter().sum::<f64>() / n, (squared / n).sqrt())
}

/// Every step's targets are 0.5 + 0.5 L of the step before (Eq. 6), which tends to the incident radiance, 1. With rates
/// alpha_k = 1 / (1 + decay + ... + decay^(k-1)) the distance to it shrinks by 1 - alpha_k / 2 in step k.
#[test]
fn the_radiance_table_tends_to_the_incident_radiance() {
    let device = Device::new();
    let scene = ours("furnace/scene.xml", &[]);
    for decay in [0.0, 0.95, 1.0] {
        let settings =
            Settings { decay, grid: 4, directions: 8, ..settings(&scene, [64, 64], Sampler::RejectionMix, 9) };
        let mut renderer = device.renderer(&scene, &settings);
        let (mut distance, mut weight) = (1.0, 0.0);
        for step in 1..=24 {
            steps(&mut renderer, &settings, step * 8);
            weight = weight * f64::from(decay) + 1.0;
            distance *= 1.0 - 0.5 / weight;
        }
        let bins = learned_bins(&renderer);
        let (mean, rms) = mean_and_deviation(&bins, 1.0 - distance);
        println!("decay {decay}: {} bins, mean {mean:.4} (expected {:.4}), rms {rms:.4}", bins.len(), 1.0 - distance);
        assert!(bins.len() > 1000, "{}", bins.len());
        assert!((mean - (1.0 - distance)).abs() < 0.01 && rms < 0.05, "decay {decay}: {mean} {rms}");
    }
}
