//! Constants that GLSL and Rust share, binding numbers, and specialization constants. `build.rs` writes them from
//! `glsl/include/shared`. This module does not depend on the device.

include!(concat!(env!("OUT_DIR"), "/constants.rs"));
include!(concat!(env!("OUT_DIR"), "/variant.rs"));
