//! Pictures: what a pixel holds, and how parts are merged. CPU only: no Vulkan, no `unsafe`.

pub mod merge;
pub mod noise;
mod picture;
pub mod ranges;
pub mod sums;
pub mod weights;

pub use picture::*;
