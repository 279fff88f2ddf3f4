//! What is left of a render whose device is lost: the picture as it was last read back.

use std::time::{Duration, Instant};

use lodestar::Result;
use lodestar::film::Picture;
use lodestar::renderer::Renderer;

/// The most that a lost device may cost.
const EVERY: Duration = Duration::from_secs(10);
/// Reading the picture back may take one part in so many of the time.
const READING_SHARE: u32 = 20;

/// A recent picture in the host's memory.
pub struct SafetyCopy {
    every: Duration,
    last: Option<Copied>,
    /// When the last one was taken, or the render began.
    taken: Instant,
    cost: Duration,
}

/// A picture of whole steps.
pub struct Copied {
    pub picture: Picture,
    /// Samples per pixel.
    pub samples: u32,
}

impl SafetyCopy {
    /// To be taken at least as often as anything that the user has asked for, where the steps are that short.
    pub fn new(wanted: impl IntoIterator<Item = Duration>) -> Self {
        let every = wanted.into_iter().fold(EVERY, Duration::min);
        Self { every, last: None, taken: Instant::now(), cost: Duration::ZERO }
    }

    /// To be called after every step.
    pub fn after_step(&mut self, renderer: &Renderer) -> Result<()> {
        if renderer.is_stopped() || self.taken.elapsed() < self.every.max(self.cost * READING_SHARE) {
            return Ok(());
        }
        let begin = Instant::now();
        self.last = Some(Copied { picture: renderer.picture()?, samples: renderer.samples_done() });
        (self.cost, self.taken) = (begin.elapsed(), Instant::now());
        Ok(())
    }

    /// The last one.
    pub fn take(&mut self) -> Option<Copied> {
        self.last.take()
    }
}
