//! Growth of the time per ray with the number of triangles, the cells of the guide, the size of the picture, and the
//! driver's threads.
//!
//! `cargo bench --bench scaling` uses the Cornell box of relief with more and more triangles. `-- 10000000` sets the
//! maximum number of triangles (default: a million). The threads are those of lavapipe, set by `LP_NUM_THREADS`.
//! Everything that is compared takes turns, so that a slow minute affects all of it.

use std::process::Command;
use std::sync::Arc;

use lodestar::gpu::Context;
use lodestar::renderer::Renderer;
use lodestar::scene::Scene;
use lodestar::settings::{Sampler, Settings};
use support::bench::relief::tessellated;
use support::bench::{context, median, renderer, run_for, settings};

const ROUNDS: usize = 5;
const SECONDS: f64 = 1.5;
const SIZE: [u32; 2] = [256, 256];
const TRIANGLES: [usize; 5] = [1_000, 10_000, 100_000, 1_000_000, 10_000_000];
/// Argument that makes this program measure itself once and print the rate.
const ALONE: &str = "--one-rate";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let most = arguments.iter().find_map(|text| text.parse().ok()).unwrap_or(1_000_000);
    let context = context();
    if arguments.iter().any(|argument| argument == ALONE) {
        let (_, rays) = Subject::new(&context, &tessellated(10_000), SIZE, Sampler::Bsdf, 8).rates();
        return println!("{rays}");
    }
    measure("triangles", "rays", TRIANGLES.into_iter().filter(|&count| count <= most), |&count| {
        Subject::new(&context, &tessellated(count), SIZE, Sampler::Bsdf, 8)
    });
    measure("cells along each axis, product", "paths", [4, 8, 16, 32], |&cells| {
        Subject::new(&context, &tessellated(10_000), SIZE, Sampler::Product, cells)
    });
    measure("pixels along each side", "rays", [64, 128, 256, 512, 1024], |&side| {
        Subject::new(&context, &tessellated(10_000), [side, side], Sampler::Bsdf, 8)
    });
    if context.device().name.contains("llvmpipe") {
        measure_threads();
    }
}

/// Renderer that is measured.
struct Subject {
    renderer: Renderer,
    settings: Settings,
}

impl Subject {
    fn new(context: &Arc<Context>, scene: &Scene, size: [u32; 2], sampler: Sampler, grid: u32) -> Self {
        let settings = Settings { grid: Some(grid), ..settings(scene, size, sampler) };
        Self { renderer: renderer(context, scene, &settings, 4), settings }
    }

    /// Millions of paths per second, and millions of rays per second.
    fn rates(&mut self) -> (f64, f64) {
        let (spp, seconds, counts) = run_for(&mut self.renderer, SECONDS, &self.settings);
        let paths = f64::from(spp) * f64::from(self.settings.width * self.settings.height);
        (paths / seconds / 1.0e6, counts.rays as f64 / seconds / 1.0e6)
    }
}

/// Prints for each value the medians over all rounds, and the time relative to the first value.
fn measure<T: std::fmt::Display>(
    title: &str,
    unit: &str,
    values: impl IntoIterator<Item = T>,
    subject: impl Fn(&T) -> Subject,
) {
    let mut subjects: Vec<_> = values.into_iter().map(|value| (subject(&value), value)).collect();
    let mut rates = vec![Vec::new(); subjects.len()];
    for _ in 0..ROUNDS {
        for (rates, (subject, _)) in rates.iter_mut().zip(&mut subjects) {
            let (paths, rays) = subject.rates();
            rates.push(if unit == "rays" { rays } else { paths });
        }
    }
    println!("\n{title} | M{unit}/s | time of one, relative to the first");
    for (own, (_, value)) in rates.iter().zip(&subjects) {
        let ratios = own.iter().zip(&rates[0]).map(|(own, first)| first / own).collect();
        println!("{value} | {:.2} | {:.2}", median(own.clone()), median(ratios));
    }
}

/// Measures the rate for several numbers of threads. The driver reads that number once, so each needs a process of its
/// own.
fn measure_threads() {
    println!("\nthreads of the driver | Mrays/s | gain");
    let rate = |threads: u32| -> Option<f64> {
        let program = std::env::current_exe().ok()?;
        let output = Command::new(program).arg(ALONE).env("LP_NUM_THREADS", threads.to_string()).output().ok()?;
        let rate = String::from_utf8(output.stdout).ok()?.lines().last()?.trim().parse().ok();
        if rate.is_none() {
            println!("with {threads} threads: {}", String::from_utf8_lossy(&output.stderr).trim());
        }
        rate
    };
    let rounds: Vec<_> = (0..ROUNDS).filter_map(|_| Some([rate(1)?, rate(2)?, rate(4)?])).collect();
    for (place, threads) in [1, 2, 4].into_iter().enumerate().filter(|_| !rounds.is_empty()) {
        let rates = rounds.iter().map(|round| round[place]).collect();
        let gains = rounds.iter().map(|round| round[place] / round[0]).collect();
        println!("{threads} | {:.2} | {:.2}", median(rates), median(gains));
    }
}
