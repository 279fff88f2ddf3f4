//! Lodestar: a path-guided renderer of Mitsuba scenes for any Vulkan device.
#![deny(missing_docs)]

pub mod bvh;
pub mod cosine_integrals;
pub mod error;
pub mod files;
pub mod film;
pub mod gpu;
pub mod image;
pub mod kernels;
pub mod layout;
pub mod reference;
pub mod renderer;
pub mod scene;
pub mod settings;

pub use error::{Error, Result};
