//! Copies of the picture in the host's memory: all that is left of a render whose device is lost.

use std::time::{Duration, Instant};

use crate::Result;
use crate::film::Picture;
use crate::renderer::Renderer;

/// The most rendering time that a lost device may cost.
const EVERY: Duration = Duration::from_secs(10);
/// Reading the picture back may take one part in so many of the time.
const READING_SHARE: u32 = 20;

/// A recent picture in the host's memory.
pub(super) struct SafetyCopy {
    every: Duration,
    last: Option<CopiedPicture>,
    /// When the last copy was made, or the render began.
    taken: Instant,
    cost: Duration,
}

/// A picture of whole steps.
pub(super) struct CopiedPicture {
    pub picture: Picture,
    /// Samples per pixel.
    pub samples: u32,
}

impl SafetyCopy {
    /// Copies are made at least as often as every interval of `wanted`, where steps are that short.
    pub fn new(wanted: impl IntoIterator<Item = Duration>) -> Self {
        let every = wanted.into_iter().fold(EVERY, Duration::min);
        Self { every, last: None, taken: Instant::now(), cost: Duration::ZERO }
    }

    /// Copies the picture after a step where it is time to.
    pub fn after_step(&mut self, renderer: &Renderer) -> Result<()> {
        if renderer.is_stopped() || self.taken.elapsed() < self.every.max(self.cost * READING_SHARE) {
            return Ok(());
        }
        let begin = Instant::now();
        self.last = Some(CopiedPicture { picture: renderer.picture()?, samples: renderer.samples_done() });
        (self.cost, self.taken) = (begin.elapsed(), Instant::now());
        Ok(())
    }

    /// Takes the last copy.
    pub fn take(&mut self) -> Option<CopiedPicture> {
        self.last.take()
    }
}
