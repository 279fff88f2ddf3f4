//! The checkpoints of one render: kept in memory after every step, written now and then and at the end.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::renderer::Renderer;
use crate::session::checkpoint::{Checkpoint, Record};
use crate::session::history::History;
use crate::session::identity::Identity;
use crate::{Error, Result, files};

/// A checkpoint's file and the interval at which it is written.
#[derive(Debug, Clone)]
pub(super) struct CheckpointFile {
    pub path: PathBuf,
    pub every: Duration,
}

impl CheckpointFile {
    /// The file, written every so many seconds.
    pub fn new(path: &Path, seconds: f64) -> Self {
        // A time too long to count in never comes.
        Self { path: path.to_path_buf(), every: Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX) }
    }

    /// Fails where the file cannot be written.
    pub fn check_writable(&self) -> Result<()> {
        files::check_writable(&self.path)
    }

    /// Fails where the file exists: a new render never takes an older one's place.
    pub fn check_absent(&self, identity: &Identity) -> Result<()> {
        if !self.path.exists() {
            return Ok(());
        }
        let file = self.path.display();
        let Checkpoint { scene, settings, state, .. } = Checkpoint::read(&self.path).map_err(|error| {
            Error::checkpoint(
                &self.path,
                format!("the file is there already and no checkpoint to go on with; give another name ({error})"),
            )
        })?;
        let message = match Identity::of_render(&scene.hash, &settings).difference(identity) {
            Some(difference) => {
                format!("it is the checkpoint of another render: {difference}; give another name or remove it")
            }
            None => format!(
                "it holds {} samples per pixel of this render already: `lodestar resume {file}` goes on with them; remove it to begin anew",
                state.samples_done
            ),
        };
        Err(Error::checkpoint(&self.path, message))
    }
}

/// Reading the state back may take one part in so many of the time: where steps are short, several pass between two readings.
const READING_SHARE: u32 = 20;

/// The checkpoints of one render.
///
/// They hold steps of the full length only. So a signal in the middle of a step costs that step, and a resumed render has the
/// bits of one that was longer from the start.
pub(super) struct Checkpoints {
    file: CheckpointFile,
    /// A checkpoint of this render with nothing rendered yet.
    template: Checkpoint,
    last: Option<Snapshot>,
    last_write: Instant,
    /// Samples per pixel in the file.
    samples_written: Option<u32>,
    /// Whether the last attempt to write it has failed.
    is_failing: bool,
}

struct Snapshot {
    checkpoint: Checkpoint,
    taken: Instant,
    cost: Duration,
}

impl Checkpoints {
    /// Keeps the render that `template` describes in `file`, which holds it after `samples_written` samples, if at all.
    pub fn new(file: CheckpointFile, template: Checkpoint, samples_written: Option<u32>) -> Self {
        Self { file, template, last: None, last_write: Instant::now(), samples_written, is_failing: false }
    }

    /// Reads the state back before a step of so many samples, where it is time to or the next state to keep may be far away.
    pub fn before_step(&mut self, renderer: &Renderer, history: &History, samples: u32) -> Result<()> {
        let is_due = self.last.as_ref().is_none_or(|last| last.taken.elapsed() >= last.cost * READING_SHARE);
        let is_last = samples < renderer.samples_of_next_step();
        if is_due || is_last { self.take(renderer, history) } else { Ok(()) }
    }

    /// Writes the file after a step where it is time to. After a failure, which is returned once, it waits as long as after a
    /// success.
    pub fn after_step(&mut self, renderer: &Renderer, history: &History) -> Result<()> {
        if self.last_write.elapsed() < self.file.every {
            return Ok(());
        }
        let written = self.take(renderer, history).and_then(|()| self.write());
        let is_news = !self.is_failing;
        (self.last_write, self.is_failing) = (Instant::now(), written.is_err());
        if is_news { written } else { Ok(()) }
    }

    /// Writes the last step that can be kept, at the end of a render, however it ended.
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
        let record = Record { history: history.clone(), ..self.template.record.clone() };
        let checkpoint = Checkpoint { record, state, ..self.template.clone() };
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
