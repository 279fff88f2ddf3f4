//! Loading time and memory of the scene kitchen, from the start of the command to the first sample. The time that
//! Mitsuba 3 takes to load the same file stands beside it where Python has Mitsuba. All measurements are interleaved in
//! one run, with a warm disk cache.
//!
//! `cargo bench --bench loading`. `LODESTAR_SCENES` chooses the shared scenes, `LODESTAR_LOADING_SCENE` another file.
//! Mitsuba needs `DRJIT_LIBLLVM_PATH`.

use std::path::{Path, PathBuf};
use std::process::Command;

use support::bench::median;

const ROUNDS: usize = 7;
const VARIANTS: [&str; 2] = ["llvm_ad_rgb", "scalar_rgb"];

fn main() {
    let folder = std::env::var_os("LODESTAR_SCENES").map(PathBuf::from).unwrap_or_default();
    let scene = std::env::var_os("LODESTAR_LOADING_SCENE");
    let scene = scene.map_or_else(|| folder.join("kitchen/scene.xml"), PathBuf::from);
    if !scene.is_file() {
        return println!(
            "skipped: {} is not there; LODESTAR_SCENES names the folder of the shared scenes",
            scene.display()
        );
    }
    let folder = tempfile::tempdir().expect("a folder");
    let rows: Vec<[f64; 3]> = (0..=ROUNDS)
        .map(|round| {
            let own = first_sample_seconds(&scene, folder.path());
            let others = VARIANTS.map(|variant| mitsuba_seconds(&scene, variant));
            println!("round {round}: {own:.2} s; Mitsuba {others:.2?} s");
            [own, others[0], others[1]]
        })
        // The first run fills the caches of the disk and the driver.
        .skip(1)
        .collect();
    println!("\nmedians over {ROUNDS} rounds, {}:", scene.display());
    println!("  command to first sample  {:6.2} s", median(rows.iter().map(|row| row[0]).collect()));
    for (column, variant) in VARIANTS.into_iter().enumerate() {
        let seconds = median(rows.iter().map(|row| row[column + 1]).collect());
        let ratio = median(rows.iter().map(|row| row[0] / row[column + 1]).collect());
        println!("  Mitsuba loads, {variant:<11} {seconds:6.2} s; ratio {ratio:.2}");
    }
}

/// Time from the start of the command to the first sample, in seconds. Prints the memory that the command reports.
fn first_sample_seconds(scene: &Path, folder: &Path) -> f64 {
    let stats = folder.join("stats.json");
    let status = Command::new(env!("CARGO_BIN_EXE_lodestar"))
        .arg("render")
        .arg(scene)
        .args(["-q", "--width", "8", "--height", "8", "--spp", "1", "-o"])
        .arg(folder.join("picture.exr"))
        .arg("--stats")
        .arg(&stats)
        .status();
    assert!(status.expect("lodestar starts").success());
    let stats = std::fs::read_to_string(stats).expect("the statistics");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    let [resident, device] = ["peak_resident_bytes", "peak_bytes"].map(|name| stats["totals"][name].as_f64());
    let times =
        ["load_seconds", "bvh_seconds", "pipeline_seconds"].map(|name| stats[name].as_f64().unwrap_or(f64::NAN));
    if let (Some(resident), Some(device)) = (resident, device) {
        let megabytes = resident / 1.0e6;
        println!("load, BVH, pipelines: {times:.2?} s; {megabytes:.0} MB, {:.2} x the device's", resident / device);
    }
    stats["setup_seconds"].as_f64().expect("the time until the first sample")
}

/// Loading time of Mitsuba in seconds; NaN if Mitsuba is not available.
fn mitsuba_seconds(scene: &Path, variant: &str) -> f64 {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mitsuba_loading.py");
    let output = Command::new("python3").arg("-B").args([script.as_ref(), scene.as_os_str()]).arg(variant).output();
    let text = output.ok().and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    text.split_whitespace().next().and_then(|seconds| seconds.parse().ok()).unwrap_or(f64::NAN)
}
