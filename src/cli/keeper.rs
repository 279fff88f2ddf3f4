//! Keeps a render's checkpoints: in memory after every step, on disk now and then and at the end.

use std::time::{Duration, Instant};

use lodestar::Result;
use lodestar::renderer::Renderer;
use lodestar::session::checkpoint::Checkpoint;

use super::task::{CheckpointFile, History, JobRecord};

/// Reading the state back may take one part in so many of the time: where steps are short, several pass between two readings.
const READING_SHARE: u32 = 20;

/// The checkpoints of one render.
///
/// They hold steps of the full length only. So a signal in the middle of a step costs that step, and a render that is gone on
/// with beyond its end has the bits of one that was longer from the start.
pub struct Keeper {
    file: CheckpointFile,
    /// All that does not change, with the state from which the render began.
    template: Checkpoint<JobRecord>,
    last: Option<Snapshot>,
    last_write: Instant,
    /// What the file holds.
    samples_written: Option<u32>,
    /// Whether the last attempt to write it has failed.
    is_failing: bool,
}

struct Snapshot {
    checkpoint: Checkpoint<JobRecord>,
    taken: Instant,
    cost: Duration,
}

impl Keeper {
    /// Keeps in `file` the render that `template` describes; the file holds it after `samples_written` samples, if at all.
    pub fn new(file: CheckpointFile, template: Checkpoint<JobRecord>, samples_written: Option<u32>) -> Self {
        Self { file, template, last: None, last_write: Instant::now(), samples_written, is_failing: false }
    }

    /// To be called before a step of so many samples: the next state that is kept may be far away.
    pub fn before_step(&mut self, renderer: &Renderer, history: &History, samples: u32) -> Result<()> {
        let is_due = self.last.as_ref().is_none_or(|last| last.taken.elapsed() >= last.cost * READING_SHARE);
        let is_last = samples < renderer.samples_of_next_step();
        if is_due || is_last { self.take(renderer, history) } else { Ok(()) }
    }

    /// To be called after a step: writes the file where it is time to. After a failure, which is returned once, it waits as
    /// long as after a success.
    pub fn after_step(&mut self, renderer: &Renderer, history: &History) -> Result<()> {
        if self.last_write.elapsed() < self.file.every {
            return Ok(());
        }
        let written = self.take(renderer, history).and_then(|()| self.write());
        let is_news = !self.is_failing;
        (self.last_write, self.is_failing) = (Instant::now(), written.is_err());
        if is_news { written } else { Ok(()) }
    }

    /// To be called when the render has ended, however: writes what is known of the last step that is kept.
    pub fn finish(&mut self, renderer: &Renderer, history: &History) -> Result<()> {
        let taken = self.take(renderer, history);
        taken.and(self.write())
    }

    /// Reads the state back unless it is known or is none to keep.
    fn take(&mut self, renderer: &Renderer, history: &History) -> Result<()> {
        let samples = renderer.samples_done();
        let is_known = self.last.as_ref().is_some_and(|last| last.checkpoint.state.samples_done == samples);
        if is_known || !renderer.is_at_step_end() {
            return Ok(());
        }
        let begin = Instant::now();
        // The old one stays until then: the device may be lost.
        let state = renderer.state()?;
        let job = JobRecord { history: history.clone(), ..self.template.job.clone() };
        let checkpoint = Checkpoint { job, state, ..self.template.clone() };
        self.last = Some(Snapshot { checkpoint, taken: Instant::now(), cost: begin.elapsed() });
        Ok(())
    }

    /// Writes the last state that is known; the device is left alone, for it may be lost.
    pub fn write(&mut self) -> Result<()> {
        let Some(Snapshot { checkpoint, .. }) = &self.last else { return Ok(()) };
        let samples = Some(checkpoint.state.samples_done);
        if self.samples_written != samples {
            checkpoint.write(&self.file.path)?;
            self.samples_written = samples;
        }
        Ok(())
    }
}
