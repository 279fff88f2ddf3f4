//! Lodestar: a path-guided renderer of Mitsuba scenes for any Vulkan device.
#![deny(missing_docs)]

pub mod error;
pub mod film;
pub mod gpu;
pub mod scene;

pub use error::{Error, Result};
