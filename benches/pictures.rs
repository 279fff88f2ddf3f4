//! Pictures for the documents: the shared scenes, rendered well, and `scenes/door-ajar` as on the first page.
//!
//! `LODESTAR_OUT=DIR cargo bench --bench pictures [-- SCENE...]` renders each scene of `LODESTAR_SCENES` for
//! `LODESTAR_SECONDS` (50) with the default settings, and writes `DIR/SCENE.jpg`. Loading does not count. For `door-ajar`
//! it writes three pictures, which take 0.3, 0.3 and 2.1 times as long. `benches/pictures.sh` calls this bench.

use std::sync::Arc;

use lodestar::gpu::Context;
use lodestar::image::Image;
use lodestar::scene::{LoadOptions, Scene};
use lodestar::settings::{Sampler, Settings};
use support::bench::pictures::{out_folder, write_jpeg};
use support::bench::{SHARED_SCENES, context, load, renderer, run_for};

const SECONDS: f64 = 50.0;
/// Length of a picture's longer side in pixels.
const SIDE: u32 = 400;
const DOOR_AJAR: &str = "door-ajar";
/// Files of `door-ajar`: name, sampler, and time relative to that of a scene.
const DOOR_AJAR_FILES: [(&str, Sampler, f64); 3] = [
    ("door-ajar-bsdf", Sampler::Bsdf, 0.3),
    ("door-ajar-guided", Sampler::RejectionMix, 0.3),
    ("door-ajar-converged", Sampler::RejectionMix, 2.1),
];
/// Tries of rejection for `door-ajar`.
const DOOR_AJAR_TRIES: u32 = 31;

fn main() {
    let Some(folder) = out_folder() else {
        println!("skipped: LODESTAR_OUT names no folder for the pictures");
        return;
    };
    let seconds = std::env::var("LODESTAR_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(SECONDS);
    let asked: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let is_asked = |name: &str| asked.is_empty() || asked.iter().any(|asked| asked == name);
    let context = context();
    if is_asked(DOOR_AJAR) {
        let path = std::path::Path::new("scenes").join(DOOR_AJAR).join("scene.xml");
        let scene = lodestar::scene::load(&path, &LoadOptions::default()).expect("the scene loads");
        for (file, sampler, share) in DOOR_AJAR_FILES {
            let settings = Settings { nee: false, max_tries: DOOR_AJAR_TRIES, ..of_sampler(&scene, sampler) };
            write_jpeg(&folder.join(format!("{file}.jpg")), &rendered(&context, &scene, &settings, share * seconds));
        }
    }
    for name in SHARED_SCENES.iter().filter(|name| is_asked(name)) {
        let scene = load(name);
        let settings = of_sampler(&scene, Sampler::Product);
        write_jpeg(&folder.join(format!("{name}.jpg")), &rendered(&context, &scene, &settings, seconds));
    }
}

/// Default settings of a sampler, at the size of the documents' pictures.
fn of_sampler(scene: &Scene, sampler: Sampler) -> Settings {
    let defaults = Settings::for_scene(scene);
    let longer = f64::from(defaults.width.max(defaults.height));
    let scaled = |side: u32| (f64::from(side) * f64::from(SIDE) / longer).round() as u32;
    Settings { width: scaled(defaults.width), height: scaled(defaults.height), sampler, ..defaults }
}

fn rendered(context: &Arc<Context>, scene: &Scene, settings: &Settings, seconds: f64) -> Image {
    let mut renderer = renderer(context, scene, settings, 0);
    let (samples, seconds, _) = run_for(&mut renderer, seconds, settings);
    println!("{samples} samples per pixel in {seconds:.1} s");
    renderer.picture().expect("the picture").image()
}
