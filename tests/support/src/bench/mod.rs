//! Helpers that all benches use: scenes, timed renders, medians.

pub mod digits;
pub mod guide_updates;
pub mod pictures;
pub mod rates;
pub mod rays;
pub mod relief;
pub mod subjects;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lodestar::encode::bvh::Bvh;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::renderer::{Counts, Renderer};
use lodestar::scene::{self, LoadOptions, Scene};
use lodestar::settings::{Sampler, Settings};

/// Scenes of the paper, which `LODESTAR_SCENES` holds.
pub const SHARED_SCENES: [&str; 12] = [
    "bathroom",
    "bathroom2",
    "cornell-box",
    "cornell-box-hard",
    "kitchen",
    "living-room",
    "living-room-2",
    "living-room-3",
    "staircase",
    "staircase2",
    "veach-ajar",
    "veach-ajar-2",
];

/// Path of a scene: the shared one if `LODESTAR_SCENES` names a folder, otherwise the project's own.
pub fn scene_path(name: &str) -> PathBuf {
    let folder = std::env::var_os("LODESTAR_SCENES").map_or_else(|| PathBuf::from("scenes"), PathBuf::from);
    folder.join(name).join("scene.xml")
}

pub fn load(name: &str) -> Scene {
    scene::load(&scene_path(name), &LoadOptions::default()).expect("the scene loads")
}

pub fn context() -> Arc<Context> {
    let device = std::env::var("LODESTAR_DEVICE").ok().filter(|name| !name.is_empty());
    let context = Context::new(&ContextOptions { device, validate: false }).expect("a Vulkan device");
    println!("device: {} ({})", context.device().name, context.device().driver_info);
    context
}

/// Settings of the references: box filter, at most 16 edges, Russian roulette after 8, no emitter sampling.
/// `LODESTAR_MAX_TRIES` replaces the default number of tries.
pub fn settings(scene: &Scene, [width, height]: [u32; 2], sampler: Sampler) -> Settings {
    let filter = scene::ReconstructionFilter::Box;
    let defaults = Settings::for_scene(scene);
    let max_tries =
        std::env::var("LODESTAR_MAX_TRIES").ok().and_then(|text| text.parse().ok()).unwrap_or(defaults.max_tries);
    Settings { width, height, max_depth: 16, rr_depth: 8, filter, sampler, max_tries, nee: false, ..defaults }
}

/// Renderer that has taken its first steps, so that its guide is in use.
pub fn renderer(context: &Arc<Context>, scene: &Scene, settings: &Settings, steps: u32) -> Renderer {
    let bvh = Bvh::of_scene(scene);
    let mut renderer = Renderer::new(context, scene, &bvh, settings).expect("a renderer");
    for _ in 0..steps {
        renderer.step(settings.spp_per_step, &|| false).expect("a step");
    }
    renderer
}

/// Takes steps by the settings for about `seconds`. Returns samples per pixel, seconds and statistics.
pub fn run_for(renderer: &mut Renderer, seconds: f64, settings: &Settings) -> (u32, f64, Counts) {
    let (begin, first) = (Instant::now(), renderer.samples_done());
    let mut counts = Counts::default();
    while begin.elapsed().as_secs_f64() < seconds {
        let samples = settings.samples_of_step(renderer.samples_done());
        counts.add(&renderer.step(samples, &|| false).expect("a step").counts);
    }
    (renderer.samples_done() - first, begin.elapsed().as_secs_f64(), counts)
}

/// Median: the middle value, or the upper of the two middle values.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
