//! Compiles every kernel under `glsl/` to SPIR-V, reflects the SPIR-V, and writes Rust code that describes it. The work
//! is done in `build/mod.rs`. The published crate contains the SPIR-V and compiles it only with the feature `shaderc`.

#[path = "build/mod.rs"]
mod generate;

use std::path::{Path, PathBuf};
use std::{env, process};

fn main() {
    // Cargo would run the script at every build if it watched a folder that is missing.
    for watched in ["glsl", "build.rs", "build", "spirv"].into_iter().filter(|path| Path::new(path).exists()) {
        println!("cargo::rerun-if-changed={watched}");
    }
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    if let Err(message) = generate::run(&out) {
        for line in message.lines() {
            println!("cargo::error={line}");
        }
        process::exit(1);
    }
}
