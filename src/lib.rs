//! Lodestar: a path-guided renderer of Mitsuba scenes for any Vulkan device.
#![deny(missing_docs)]

pub mod error;
pub mod files;
pub mod film;
pub mod image;
pub mod scene;

pub use error::{Error, Result};
