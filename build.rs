//! Compiles every kernel under `glsl/` to SPIR-V, reflects the SPIR-V, and writes Rust code that describes it. The work
//! is done in `build/mod.rs`.

#[path = "build/mod.rs"]
mod generate;

use std::path::PathBuf;
use std::{env, process};

fn main() {
    for watched in ["glsl", "build.rs", "build"] {
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
