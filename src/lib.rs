//! Lodestar renders scenes of Mitsuba, pbrt, glTF, USD and Blender with path guiding, on any Vulkan device. It uses compute kernels and needs no
//! ray-tracing extension.
//! The method is "Fast and Lightweight Path Guiding Algorithm on GPU" (Kim and Kim, Pacific Graphics 2021), in an unbiased form.
//!
//! # A render in three lines
//! ```no_run
//! let picture = lodestar::render("scenes/furnace/scene.xml", &lodestar::Options::new().samples(64))?;
//! let rgb: &[[f32; 3]] = picture.rgb();
//! # Ok::<(), lodestar::Error>(())
//! ```
//! [`Session`] renders step by step, with a callback, from checkpoints and to files. [`Scene`] is read from a file or made in
//! code. `examples/` has one program for each of the three.
//!
//! The chapter below is `docs/architecture.md`. `docs/method.md` has the paper map: which equation is which function, and which
//! test proves it.
#![doc = ""]
#![doc = include_str!("../docs/architecture.md")]
#![deny(missing_docs)]

// The command line reads as a program that uses the library.
extern crate self as lodestar;

use std::path::Path;

pub mod scene;
pub mod session;
pub mod settings;

// The hidden modules are for the command line, the tests and the benches. They are no public API and may change in any version.
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod denoise;
#[doc(hidden)]
pub mod encode;
#[doc(hidden)]
pub mod error;
#[doc(hidden)]
pub mod files;
#[doc(hidden)]
pub mod film;
#[doc(hidden)]
pub mod fleet;
#[doc(hidden)]
pub mod generated;
#[doc(hidden)]
pub mod gpu;
#[doc(hidden)]
pub mod image;
#[doc(hidden)]
pub mod inputs;
#[doc(hidden)]
pub mod layers;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod quoted;
#[doc(hidden)]
pub mod radiance_map;
#[doc(hidden)]
pub mod renderer;
#[cfg(feature = "reproduce")]
#[doc(hidden)]
pub mod reproduce;
#[doc(hidden)]
pub mod spirv;
#[cfg(feature = "view")]
#[doc(hidden)]
pub mod view;

pub use error::{Error, Result};
pub use film::Picture;
pub use gpu::{Context, ContextOptions};
pub use scene::{Camera, Scene};
pub use session::{Options, Progress, Session};
pub use settings::Settings;

/// Renders a Mitsuba scene to a picture in memory.
///
/// ```no_run
/// let picture = lodestar::render("scene.xml", &lodestar::Options::new().samples(64))?;
/// # Ok::<(), lodestar::Error>(())
/// ```
///
/// # Errors
/// Where the scene cannot be read, an option does not suit it, no device can be used, or a result would be wrong.
pub fn render(scene: impl AsRef<Path>, options: &Options) -> Result<Picture> {
    let mut session = Session::open(scene, options)?;
    session.run(|_| std::ops::ControlFlow::Continue(()))?;
    session.picture()
}
