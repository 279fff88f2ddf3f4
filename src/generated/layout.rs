//! Structs that cross to GLSL, which declares them. `build.rs` writes them, and compares those in buffers with the SPIR-V.

use bytemuck::{Pod, Zeroable};

/// Size of a texel, in bytes.
pub const TEXEL_BYTES: usize = 16;

include!(concat!(env!("OUT_DIR"), "/layout.rs"));
