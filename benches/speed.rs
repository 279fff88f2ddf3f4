//! Paths per second on cornell-box: `bsdf` and `rejection-mix`, and Mitsuba 3 where Python has it, interleaved in one run.
//!
//! `cargo bench --bench speed`; `LODESTAR_SCENES` chooses the shared scene, `DRJIT_LIBLLVM_PATH` serves Mitsuba.

#[path = "common/mod.rs"]
mod common;

use std::process::Command;

use common::{context, load, median, renderer, run_for, scene_path, settings};
use lodestar::settings::Sampler;

const SIZE: u32 = 512;
const ROUNDS: usize = 5;
const SECONDS: f64 = 3.0;

fn main() {
    let context = context();
    let scene = load("cornell-box");
    let pixels = f64::from(SIZE * SIZE);
    let samplers = [Sampler::Bsdf, Sampler::RejectionMix];
    let mut renderers = samplers.map(|sampler| renderer(&context, &scene, &settings(&scene, SIZE, sampler), 4));
    let mut rates: Vec<[f64; 3]> = Vec::new();
    for round in 0..ROUNDS {
        let mut row = [f64::NAN; 3];
        for (rate, renderer) in row.iter_mut().zip(&mut renderers) {
            let (spp, seconds, counts) = run_for(renderer, SECONDS, 8);
            *rate = f64::from(spp) * pixels / seconds / 1.0e6;
            println!("round {round}: {rate:.3} Mpaths/s, {:.2} Mrays/s", counts.rays as f64 / seconds / 1.0e6);
        }
        row[2] = mitsuba_rate().unwrap_or(f64::NAN);
        rates.push(row);
    }
    let column = |i: usize| median(rates.iter().map(|row| row[i]).collect());
    let ratio = |a: usize, b: usize| median(rates.iter().map(|row| row[a] / row[b]).collect());
    println!("\nmedians over {ROUNDS} rounds, {SIZE} x {SIZE}, depth 16, roulette after 8, box filter:");
    println!("  bsdf           {:8.3} Mpaths/s", column(0));
    println!("  rejection-mix  {:8.3} Mpaths/s, {:.2} x the time per sample of bsdf", column(1), ratio(0, 1));
    match rates.iter().all(|row| row[2].is_finite()) {
        true => println!("  Mitsuba path   {:8.3} Mpaths/s, bsdf is {:.2} x as fast", column(2), ratio(0, 2)),
        false => println!("  Mitsuba        not found: pip install mitsuba, and name LLVM in DRJIT_LIBLLVM_PATH"),
    }
}

/// Mitsuba's `path` integrator (llvm_ad_rgb, emitter sampling on) on the same scene at the same size.
fn mitsuba_rate() -> Option<f64> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mitsuba_speed.py");
    let scene = scene_path("cornell-box");
    let output =
        Command::new("python3").args([script.as_ref(), scene.as_os_str()]).arg(SIZE.to_string()).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}
