//! News of a render under way.

use std::fmt;

use crate::film::noise::NoiseReport;
use crate::scene::LoadProgress;
use crate::session::length::Length;

/// How far a render is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Samples per pixel so far.
    pub samples: u32,
    /// Seconds of rendering so far.
    pub seconds: f64,
    /// Paths so far.
    pub paths: u64,
    /// Share of the last step's paths that reached a light, in [0, 1]. It grows as the guide learns.
    pub light_hit_rate: f64,
    /// Noise of the picture, where noise ends the render.
    pub noise: Option<NoiseReport>,
    /// Share of the render that is done, in [0, 1], by samples or by time, whichever is further.
    pub fraction: f64,
    /// The end of the render.
    pub length: Length,
}

/// Work that precedes the first step. Prints as `building the kernels`, say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preparation {
    /// The scene's files are being read.
    Scene(LoadProgress),
    /// The hierarchy of so many primitives is being built.
    Hierarchy(usize),
    /// The kernels are being built.
    Kernels,
}

impl fmt::Display for Preparation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene(progress) => write!(f, "{progress}"),
            Self::Hierarchy(primitives) => write!(f, "building the BVH of {primitives} primitives"),
            Self::Kernels => write!(f, "building the kernels"),
        }
    }
}

/// News for whoever watches a render, in this order: preparations, `Ready`, steps, `Rendered`. Messages come at any time.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// Work that precedes the first step has begun.
    Preparing(Preparation),
    /// The first step can begin.
    Ready,
    /// A step has ended.
    Step(&'a Progress),
    /// The last step has ended. The files follow.
    Rendered,
    /// A warning in one sentence.
    Warning(&'a str),
    /// A message of Vulkan's validation layer.
    Validation(&'a str),
}

/// A caller's view of a render, and its way to stop it.
pub struct Watch<'a> {
    /// Asked between two dispatches. True ends the render; its files are still written.
    pub stop: &'a dyn Fn() -> bool,
    /// Told all news, from several threads while a scene is read.
    pub events: &'a (dyn Fn(Event<'_>) + Sync),
}

impl Watch<'_> {
    /// A watch that hears nothing and stops nothing.
    pub fn silent() -> Self {
        Self { stop: &|| false, events: &|_| {} }
    }

    pub(super) fn tell(&self, event: Event<'_>) {
        (self.events)(event);
    }

    pub(super) fn warn(&self, message: &str) {
        self.tell(Event::Warning(message));
    }
}
