//! Output of `build.rs`.

pub mod constants;
pub mod interface;
pub mod kernels;
pub mod layout;
