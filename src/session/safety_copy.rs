//! Safety copies of the picture in the host's memory. When the device is lost, nothing else is left of the render.

use std::time::{Duration, Instant};

use crate::Result;
use crate::film::Picture;
use crate::fleet::Fleet;

/// Longest time between two copies, which is the rendering time that a lost device may cost.
const EVERY: Duration = Duration::from_secs(10);
/// Least ratio of the time between two copies to the time that one copy takes.
const READING_SHARE: u32 = 20;

/// A recent picture in the host's memory.
pub(super) struct SafetyCopy {
    every: Duration,
    last: Option<CopiedPicture>,
    /// Time of the last copy, or of the render's begin.
    taken: Instant,
    /// Time that the last copy took.
    cost: Duration,
}

/// A picture after a whole step.
pub(super) struct CopiedPicture {
    pub picture: Picture,
    /// Number of samples per pixel.
    pub samples: u32,
}

impl SafetyCopy {
    /// A safety copy without a picture yet. It is renewed after 10 seconds, or after the shortest interval of `wanted`.
    pub fn new(wanted: impl IntoIterator<Item = Duration>) -> Self {
        let every = wanted.into_iter().fold(EVERY, Duration::min);
        Self { every, last: None, taken: Instant::now(), cost: Duration::ZERO }
    }

    /// Copies the picture after a step, if the interval has passed.
    pub fn after_step(&mut self, fleet: &Fleet) -> Result<()> {
        if fleet.first().is_stopped()
            || !fleet.first().has_copies()
            || self.taken.elapsed() < self.every.max(self.cost * READING_SHARE)
        {
            return Ok(());
        }
        let begin = Instant::now();
        self.last = Some(CopiedPicture { picture: fleet.picture()?, samples: fleet.first().samples_done() });
        (self.cost, self.taken) = (begin.elapsed(), Instant::now());
        Ok(())
    }

    /// Takes the last copy.
    pub fn take(&mut self) -> Option<CopiedPicture> {
        self.last.take()
    }
}
