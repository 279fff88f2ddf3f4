//! Output of `build.rs`, and the structs that `build.rs` compares with the kernels.

pub mod constants;
pub mod interface;
pub mod kernels;
pub mod layout;
