//! Does guiding pay? The paper's error (MAE of the displayed image) of `bsdf` and `rejection-mix` after the same seconds,
//! interleaved, and the light-hit rate per step (Fig. 7a).
//!
//! `cargo bench --bench equal_time`; needs the shared scenes and references: `LODESTAR_SCENES`, `LODESTAR_REFERENCES`.

#[path = "common/mod.rs"]
mod common;

use std::path::PathBuf;
use std::sync::Arc;

use common::{context, load, median, run_for, settings};
use lodestar::gpu::Context;
use lodestar::image::{Image, exr, metrics};
use lodestar::settings::Sampler;

const SCENES: [&str; 2] = ["cornell-box", "cornell-box-hard"];
const ROUNDS: u32 = 3;
const SECONDS: f64 = 10.0;

fn main() {
    let Some(references) = std::env::var_os("LODESTAR_REFERENCES").map(PathBuf::from) else {
        println!("skipped: LODESTAR_REFERENCES names no folder with reference images");
        return;
    };
    let context = context();
    for name in SCENES {
        let reference = exr::read_rgb(&references.join(format!("{name}.mean.exr"))).expect("the reference");
        let rows: Vec<[f64; 2]> = (0..ROUNDS)
            .map(|round| {
                [Sampler::Bsdf, Sampler::RejectionMix].map(|sampler| error(&context, name, &reference, sampler, round))
            })
            .collect();
        let ratio = median(rows.iter().map(|[bsdf, guided]| guided / bsdf).collect());
        println!("{name}: MAE(rejection-mix) / MAE(bsdf) = {ratio:.3} at {SECONDS} s, median of {ROUNDS}");
        print_hit_rates(&context, name, [reference.width, reference.height]);
    }
}

fn error(context: &Arc<Context>, name: &str, reference: &Image, sampler: Sampler, seed: u32) -> f64 {
    let scene = load(name);
    let settings =
        lodestar::settings::Settings { seed, ..settings(&scene, [reference.width, reference.height], sampler) };
    let mut renderer = common::renderer(context, &scene, &settings, 0);
    let (spp, _, _) = run_for(&mut renderer, SECONDS, settings.spp_per_step);
    let picture = renderer.picture().expect("the picture").image();
    let error = metrics::compare(&picture, reference).expect("same size").mae_ldr;
    println!("{name} {sampler:?} seed {seed}: {spp} spp, MAE {error:.5}");
    error
}

fn print_hit_rates(context: &Arc<Context>, name: &str, size: [u32; 2]) {
    for sampler in [Sampler::Bsdf, Sampler::RejectionMix] {
        let scene = load(name);
        let settings = settings(&scene, size, sampler);
        let mut renderer = common::renderer(context, &scene, &settings, 0);
        let mut rate = || renderer.step(settings.spp_per_step, &|| false).expect("a step").counts.light_hit_rate();
        let rates: Vec<String> = (0..10).map(|_| format!("{:.2}", 100.0 * rate())).collect();
        println!("{name} {sampler:?}: light-hit rate of steps 1 to 10, %: {}", rates.join(" "));
    }
}
