//! What `build.rs` writes from `glsl/`, and the structs that it holds against the kernels.

pub mod constants;
pub mod interface;
pub mod kernels;
pub mod layout;
