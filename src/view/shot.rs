//! Shots: copies of a picture for viewers.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use crate::film::Picture;
use crate::image::layers::Layers;
use crate::view::denoiser::LazyDenoiser;
use crate::view::planes::{self, Plane};

/// Name of the layer that a denoiser makes.
pub(super) const DENOISED: &str = "denoised";

/// A picture at one moment.
pub(super) struct Shot {
    /// Number of the shot, counted from 1.
    pub number: u64,
    /// Number of the viewer's wish that the camera follows; 0 without one.
    pub wish: u64,
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    pub content: Content,
    noise: OnceLock<Option<f64>>,
    denoiser: Option<Arc<LazyDenoiser>>,
    /// The denoised radiance. It is made when it is asked for first.
    denoised: OnceLock<Option<Plane>>,
}

/// Pixels of a shot.
pub(super) enum Content {
    /// The picture of a render.
    Rendered(Box<Picture>),
    /// The layers of a file.
    Read(Layers),
}

impl Shot {
    pub fn new(number: u64, samples: u64, seconds: f64, content: Content) -> Self {
        let (noise, denoised) = (OnceLock::new(), OnceLock::new());
        Self { number, wish: 0, samples, seconds, content, noise, denoiser: None, denoised }
    }

    /// Names the wish that the camera follows.
    pub fn following(self, wish: u64) -> Self {
        Self { wish, ..self }
    }

    /// Lets the page ask for a layer `denoised` of a rendered picture.
    pub fn with_denoiser(self, denoiser: Option<Arc<LazyDenoiser>>) -> Self {
        Self { denoiser, ..self }
    }

    pub fn size(&self) -> [u32; 2] {
        match &self.content {
            Content::Rendered(picture) => [picture.width, picture.height],
            Content::Read(layers) => [layers.width, layers.height],
        }
    }

    /// Offset of the window within the whole film.
    pub fn offset(&self) -> [u32; 2] {
        match &self.content {
            Content::Rendered(picture) => picture.offset,
            Content::Read(layers) => layers.offset,
        }
    }

    /// Names of the layers.
    pub fn layers(&self) -> Vec<String> {
        match &self.content {
            Content::Rendered(picture) => planes::names_of_picture(picture),
            Content::Read(layers) => planes::names(layers),
        }
    }

    /// Names of the layers that the page offers: those of the shot, and the one that the denoiser makes.
    pub fn offered_layers(&self) -> Vec<String> {
        let mut names = self.layers();
        names.extend(self.denoiser.iter().filter(|denoiser| denoiser.may_exist()).map(|_| DENOISED.to_owned()));
        names
    }

    /// The layer `name`. The layer `denoised` is made when it is asked for first, which takes a moment.
    pub fn plane(&self, name: &str) -> Option<Plane> {
        if let (Content::Rendered(picture), Some(denoiser), DENOISED) = (&self.content, &self.denoiser, name) {
            return self.denoised.get_or_init(|| denoiser.denoise(picture)).clone();
        }
        let [width, height] = self.size();
        self.part(name, 0..width as usize * height as usize)
    }

    /// The layer `name` of some pixels. The layer `denoised` is there only if it has been made.
    pub fn part(&self, name: &str, pixels: Range<usize>) -> Option<Plane> {
        match &self.content {
            Content::Rendered(_) if name == DENOISED => Some(self.denoised.get()?.as_ref()?.part(pixels)),
            Content::Rendered(picture) => planes::of_picture(picture, name, pixels),
            Content::Read(layers) => planes::of_layers(layers, name, pixels),
        }
    }

    /// Estimate of the picture's noise: the standard error of a pixel over the picture's mean. `None` where the variance is unknown.
    pub fn noise(&self) -> Option<f64> {
        *self.noise.get_or_init(|| {
            let [radiance, variance] = ["radiance", "variance"].map(|name| self.plane(name));
            planes::noise(&radiance?, &variance?)
        })
    }
}
