//! Pictures: what a pixel holds, and how parts are merged. CPU only: no Vulkan, no `unsafe`.

mod denoised;
pub mod features;
pub mod identity;
pub mod layers;
pub mod merge;
pub mod noise;
mod picture;
mod picture_file;
pub mod ranges;
pub mod sums;
mod view;
pub mod weights;

pub use denoised::Denoised;
pub use picture::Picture;
pub use picture_file::{Precision, read_picture, write_picture, write_picture_as, write_picture_with};
pub use view::{Unprojection, View};
