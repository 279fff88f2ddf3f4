//! Events and progress that a render reports while it runs.

use std::collections::HashSet;
use std::fmt;
use std::path::{Path, PathBuf};

use crate::film::noise::NoiseReport;
use crate::scene::LoadProgress;
use crate::session::length::Length;
use crate::settings::Settings;

/// Progress of a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Samples per pixel so far.
    pub samples: u32,
    /// Seconds of rendering so far.
    pub seconds: f64,
    /// Paths so far.
    pub paths: u64,
    /// Share of the last step's scattered rays that hit an emitter, in [0, 1]. It grows as the guide learns.
    pub light_hit_rate: f64,
    /// Noise of the picture, if noise can end the render.
    pub noise: Option<NoiseReport>,
    /// Share of the render that is done, in [0, 1]: the larger one of its share of the samples and of the time.
    pub fraction: f64,
    /// The end of the render.
    pub length: Length,
}

impl Progress {
    /// The progress `seconds` later, without new samples.
    pub(super) fn after(&self, seconds: f64) -> Self {
        let seconds = self.seconds + seconds;
        Self { seconds, fraction: self.length.fraction(self.samples, seconds), ..*self }
    }
}

/// Work that precedes the first step. It prints as a phrase, such as `building the kernels`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preparation {
    /// The scene's files are being read.
    Scene(LoadProgress),
    /// The hierarchy is being built, over this number of primitives.
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

/// Facts about a render that are known when it begins.
#[derive(Debug, Clone, Copy)]
pub struct Beginning<'a> {
    /// Absolute path of the scene's file, or the name of a scene in memory.
    pub scene: &'a Path,
    /// Fingerprint of the scene.
    pub scene_hash: &'a str,
    /// Name of the device with its driver.
    pub device: &'a str,
    /// The settings.
    pub settings: &'a Settings,
    /// Limits of the render.
    pub length: Length,
    /// Samples per pixel that a checkpoint holds already.
    pub samples: u32,
    /// Files into which the picture is written.
    pub files: &'a [PathBuf],
}

/// Reason why a render ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// All samples were taken.
    Samples,
    /// The time was up.
    Time,
    /// Noise was low enough everywhere.
    Noise,
    /// The caller stopped the render.
    Stopped,
    /// The render or the writing of its files failed.
    Failed,
}

/// Event of a render. The order is: preparations, `Ready`, `Begun`, steps, `Rendered`, `Ended`. Other events come at any time.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// Work that precedes the first step has begun.
    Preparing(Preparation),
    /// The first step can begin.
    Ready,
    /// The render begins.
    Begun(&'a Beginning<'a>),
    /// A step has ended.
    Step(&'a Progress),
    /// A step is under way that takes longer than a second; its samples do not count yet. This comes at most once a second.
    InStep(&'a Progress),
    /// The last step has ended. The files follow.
    Rendered,
    /// This work on the last picture begins, such as `denoising the picture`.
    Finishing(&'static str),
    /// The picture so far is being written into this file. The share that is written is in [0, 1).
    Writing(&'a Path, f64),
    /// The picture so far was written into this file.
    Written(&'a Path),
    /// The render has ended, for this reason and with this progress.
    Ended(Ending, &'a Progress),
    /// A fact in one sentence that is no fault.
    Note(&'a str),
    /// A warning in one sentence.
    Warning(&'a str),
    /// A message of Vulkan's validation layer.
    Validation(&'a str),
}

/// Functions by which a caller watches a render and stops it.
pub struct Watch<'a> {
    /// Whether to stop. It is called between two dispatches; true ends the render, and its files are still written.
    pub stop: &'a dyn Fn() -> bool,
    /// Receiver of every event. While a scene is read, several threads call it.
    pub events: &'a (dyn Fn(Event<'_>) + Sync),
}

impl Watch<'_> {
    /// A watch that ignores all events and never stops the render.
    pub fn silent() -> Self {
        Self { stop: &|| false, events: &|_| {} }
    }

    pub(super) fn tell(&self, event: Event<'_>) {
        (self.events)(event);
    }

    pub(super) fn warn(&self, message: &str) {
        self.tell(Event::Warning(message));
    }

    /// Warns of each of these once.
    pub(super) fn warn_once(&self, warnings: &[String]) {
        let mut seen = HashSet::new();
        warnings.iter().filter(|warning| seen.insert(*warning)).for_each(|warning| self.warn(warning));
    }
}
