//! Pictures have the same bits however lavapipe runs: with subgroups of 4, 8 and 16, on memory full of garbage, and
//! with a program that was built in another way. The driver reads its variables when it starts, so each case is a
//! process of its own.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lodestar::film::Picture;
use lodestar::film::read_picture;
use lodestar::gpu::{Context, ContextOptions};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::scenes::{SAMPLERS, ours, settings};
use support::tier;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

use crate::determinism::bits;
use crate::device::Device;

/// Output of the program when it runs with these environment variables of the driver. Mesa's shader cache does not tell subgroup
/// sizes apart: with it, a run may get the code of another run's size.
fn lodestar(arguments: &[&str], variables: &[(&str, &str)]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_lodestar"))
        .args(arguments)
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .envs(variables.iter().copied())
        .output()
        .expect("a run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

fn render(seed: &str, define: &str, variables: &[(&str, &str)]) -> Picture {
    let folder = tempfile::tempdir().expect("a folder");
    let (output, scene) = (folder.path().join("a.exr"), root().join("scenes/cornell-box/scene.xml"));
    let (output, scene) = (output.to_str().expect("UTF-8"), scene.to_str().expect("UTF-8"));
    let size = ["--width", "64", "--height", "48", "--spp", "128", "--seed", seed, "--quiet", "-D", define];
    lodestar(&[&["render", scene, "-o", output], &size[..]].concat(), variables);
    read_picture(Path::new(output)).expect("a picture").0
}

const AS_IT_IS: &str = "white=0.725, 0.71, 0.68";

fn root() -> PathBuf {
    env!("CARGO_MANIFEST_DIR").into()
}

fn subgroup_size(width: &str) -> u64 {
    let list = lodestar(&["devices", "--json"], &[("LP_NATIVE_VECTOR_WIDTH", width)]);
    let devices: serde_json::Value = serde_json::from_str(&list).expect("JSON");
    let usable = devices["devices"].as_array().expect("a list").iter().find(|device| device["refused"].is_null());
    usable.expect("a device")["limits"]["subgroup_size"].as_u64().expect("a number")
}

/// Subgroups of 4, 8 and 16 give statistically equal pictures. Their seeds differ, so that the pictures are
/// independent.
#[test]
fn subgroups_of_4_8_and_16_give_statistically_equal_pictures() {
    if tier::is_skipped("memory_full_of_garbage_changes_no_bit, and the tests on other drivers") {
        return;
    }
    let widths = ["128", "256", "512"];
    let sizes = widths.map(subgroup_size);
    if sizes != [4, 8, 16] {
        return println!("skipped, for this driver has subgroups of {sizes:?} whatever LP_NATIVE_VECTOR_WIDTH says");
    }
    let estimate =
        |seed: &str, define: &str, width| Estimate::of(&render(seed, define, &[("LP_NATIVE_VECTOR_WIDTH", width)]));
    let eight = estimate("21", AS_IT_IS, "256");
    for (seed, width) in [("22", "128"), ("23", "512")] {
        let comparison = Comparison::new(&estimate(seed, AS_IT_IS, width), &eight, &[8, WHOLE]);
        println!("{width} bits: {comparison:?}");
        assert!(comparison.agrees(), "{width} bits: {comparison:?}");
    }
    let darker = estimate("24", "white=0.66, 0.65, 0.62", "512");
    let comparison = Comparison::new(&darker, &eight, &[8, WHOLE]);
    assert!(!comparison.agrees(), "an albedo 9 % off must be seen: {comparison:?}");
}

/// Memory full of garbage changes no bit: nothing is read before it is written.
#[test]
fn memory_full_of_garbage_changes_no_bit() {
    let [plain, poisoned] = [&[][..], &[("LVP_POISON_MEMORY", "1")]].map(|variables| render("5", AS_IT_IS, variables));
    assert!(bits(&plain) == bits(&poisoned));
}

/// Hash of all files that the program is built from.
fn hash_of_sources() -> u128 {
    let mut files = vec![root().join("build.rs"), root().join("Cargo.lock")];
    let mut folders = vec![root().join("src"), root().join("glsl"), root().join("scenes/cornell-box")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            if entry.is_dir() { folders.push(entry) } else { files.push(entry) }
        }
    }
    files.sort();
    let mut hash = Xxh3::new();
    files.iter().for_each(|file| hash.update(&fs::read(file).expect("a file")));
    hash.digest128()
}

/// All build profiles give equal bits. The first profile that runs this test writes its bits beside the build. Every
/// other profile, such as a debug build, compares its bits with them if it has the same sources and the same driver.
#[test]
fn every_profile_gives_the_same_bits() {
    let scene = ours("cornell-box/scene.xml", &[]);
    let info = Context::new(&ContextOptions::default()).expect("a device").device().clone();
    let driver = format!("{} {} {}", info.name, info.driver_name, info.driver_info);
    let device = Device::new();
    for sampler in SAMPLERS {
        let picture = device.render(&scene, &settings(&scene, [40, 30], sampler, 9), 24);
        let hash = format!("{:032x}", xxh3_128(bytemuck::cast_slice(&bits(&picture))));
        let key = xxh3_128(format!("{driver} {sampler:?} {:x}", hash_of_sources()).as_bytes());
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("same-bits-{key:032x}"));
        match fs::read_to_string(&file) {
            Ok(before) => assert_eq!(before, hash, "{sampler:?} on {driver}: another build gave other bits"),
            Err(_) => fs::write(&file, &hash).expect("a file"),
        }
        println!("{sampler:?} on {driver}: {hash}");
    }
}
