//! Paths per second of `bsdf`, `rejection-mix` and `product`, and of Mitsuba 3 where Python has it, interleaved in one
//! run.
//!
//! `cargo bench --bench speed [-- SCENE...]` measures cornell-box and staircase2 by default. `LODESTAR_SCENES` chooses
//! the shared scenes. Mitsuba needs `DRJIT_LIBLLVM_PATH`.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use lodestar::gpu::Context;
use lodestar::scene::Scene;
use lodestar::settings::{Sampler, Settings};
use support::bench::{context, load, median, renderer, run_for, scene_path, settings};

const WIDTH: u32 = 512;
const ROUNDS: usize = 5;
const SECONDS: f64 = 3.0;

fn main() {
    // Cargo itself adds `--bench`.
    let mut names: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    if names.is_empty() {
        names = ["cornell-box", "staircase2"].map(String::from).to_vec();
    }
    let context = context();
    for name in names {
        match scene_path(&name).is_file() {
            true => measure(&context, &name),
            false => println!("{name}: skipped, LODESTAR_SCENES names no folder that holds it"),
        }
    }
}

fn measure(context: &Arc<Context>, name: &str) {
    let scene = load(name);
    let size = [WIDTH, WIDTH * scene.film.height / scene.film.width];
    let pixels = f64::from(size[0] * size[1]);
    let samplers = [Sampler::Bsdf, Sampler::RejectionMix, Sampler::Product];
    let mut renderers = samplers.map(|sampler| {
        let settings = settings(&scene, size, sampler);
        (renderer(context, &scene, &settings, 4), settings)
    });
    let mut rates: Vec<[f64; 4]> = Vec::new();
    let mut rays_of_paths = [f64::NAN; 4];
    rays_of_paths[3] = rays_with_emitters_sampled(context, &scene, size);
    for round in 0..ROUNDS {
        let mut row = [f64::NAN; 4];
        for (method, (renderer, settings)) in renderers.iter_mut().enumerate() {
            let (spp, seconds, counts) = run_for(renderer, SECONDS, settings);
            let paths = f64::from(spp) * pixels;
            row[method] = paths / seconds / 1.0e6;
            rays_of_paths[method] = counts.rays as f64 / paths;
            println!("{name}, round {round}: {:.3} Mpaths/s", row[method]);
        }
        row[3] = mitsuba_rate(&scene_path(name), size).unwrap_or(f64::NAN);
        rates.push(row);
    }
    print_medians(name, size, &rates, &rays_of_paths);
}

/// Rays per path of a plain path tracer with a shadow ray at each vertex that a light may illuminate: about as many as
/// Mitsuba's.
fn rays_with_emitters_sampled(context: &Arc<Context>, scene: &Scene, size: [u32; 2]) -> f64 {
    let settings = Settings { nee: true, ..settings(scene, size, Sampler::Bsdf) };
    let samples = settings.spp_per_step;
    let counts = renderer(context, scene, &settings, 0).step(samples, &|| false).expect("a step").counts;
    (counts.rays + counts.shadow_rays) as f64 / (f64::from(samples) * f64::from(size[0] * size[1]))
}

fn print_medians(name: &str, [width, height]: [u32; 2], rates: &[[f64; 4]], rays_of_paths: &[f64; 4]) {
    let ratio = |a: usize, b: usize| median(rates.iter().map(|row| row[a] / row[b]).collect());
    let speed = |i: usize| {
        let paths = median(rates.iter().map(|row| row[i]).collect());
        format!("{paths:8.3} Mpaths/s, {:6.2} Mrays/s", paths * rays_of_paths[i])
    };
    println!("\n{name}, medians over {ROUNDS} rounds, {width} x {height}, depth 16, roulette after 8, box filter:");
    println!("  bsdf           {}", speed(0));
    println!("  rejection-mix  {}, {:.2} x the time per sample of bsdf", speed(1), ratio(0, 1));
    println!("  product        {}, {:.2} x the time per sample of bsdf", speed(2), ratio(0, 2));
    match rates.iter().all(|row| row[3].is_finite()) {
        true => println!("  Mitsuba path   {} with shadow rays, bsdf is {:.2} x as fast", speed(3), ratio(0, 3)),
        false => println!("  Mitsuba        not found: pip install mitsuba, and name LLVM in DRJIT_LIBLLVM_PATH"),
    }
}

/// Rate of Mitsuba's `path` integrator (llvm_ad_rgb, emitter sampling on) on the same scene at the same size.
fn mitsuba_rate(scene: &Path, [width, height]: [u32; 2]) -> Option<f64> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mitsuba_speed.py");
    let size = [width.to_string(), height.to_string()];
    let output = Command::new("python3").arg("-B").arg(script).arg(scene).args(size).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}
