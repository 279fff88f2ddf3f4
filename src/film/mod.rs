//! Pictures: what a pixel holds, and how parts are merged. CPU only: no Vulkan, no `unsafe`.

mod denoised;
pub mod features;
pub mod identity;
pub mod layers;
pub mod matte;
pub mod merge;
pub mod noise;
mod picture;
mod picture_file;
pub mod ranges;
pub mod strips;
pub mod sums;
mod view;
pub mod weights;

use crate::generated::layout::{FilmFeatures, FilmRadiance};

/// Bytes that a pixel takes on a device.
pub const PIXEL_BYTES: u64 = (size_of::<FilmRadiance>() + size_of::<FilmFeatures>()) as u64;

pub use denoised::Denoised;
pub use picture::Picture;
pub use picture_file::{Precision, read_picture, write_picture, write_picture_as, write_picture_with, write_strips};
pub use view::{Unprojection, View};
