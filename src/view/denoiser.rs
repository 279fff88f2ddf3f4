//! The denoiser of the page's layer `denoised`. Its library is loaded when somebody asks for that layer first.

use std::sync::OnceLock;

use crate::denoise::{DenoiseOptions, Denoiser};
use crate::film::Picture;
use crate::view::planes::Plane;

/// Sentence of a page that asks for the layer where it cannot be made.
pub const MISSING: &str =
    "Open Image Denoise cannot be used on the machine that renders; `lodestar denoise` says there why.";

/// A denoiser that may not be loaded yet.
pub struct LazyDenoiser {
    options: DenoiseOptions,
    loaded: OnceLock<Option<Denoiser>>,
}

impl LazyDenoiser {
    pub fn new(options: DenoiseOptions) -> Self {
        Self { options, loaded: OnceLock::new() }
    }

    /// Whether there may be a denoiser: nobody has tried to load it in vain.
    pub fn may_exist(&self) -> bool {
        self.loaded.get().is_none_or(Option::is_some)
    }

    /// The denoised radiance of a picture; `None` where there is no denoiser, or where it fails.
    pub fn denoise(&self, picture: &Picture) -> Option<Plane> {
        let denoiser = self.loaded.get_or_init(|| Denoiser::open(&self.options).ok()).as_ref()?;
        Some(Plane::of_color(&denoiser.denoise_picture(picture).ok()?.pixels))
    }
}
