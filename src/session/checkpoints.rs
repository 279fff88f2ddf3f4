//! Checkpoints of one render: its state is read back between steps, and written to a file at intervals and at the end.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::film::ranges::SampleRanges;
use crate::fleet::Fleet;
use crate::session::checkpoint::{Checkpoint, Record};
use crate::session::checkpoint_lock::CheckpointLock;
use crate::session::history::History;
use crate::session::progress::Watch;
use crate::settings::Settings;
use crate::{Result, files};

/// A checkpoint's file and the interval at which it is written.
#[derive(Debug)]
pub(super) struct CheckpointFile {
    pub path: PathBuf,
    pub every: Duration,
    /// Keeps other renders away from the file.
    lock: Option<CheckpointLock>,
}

impl CheckpointFile {
    /// The file at `path`, written every `seconds` seconds. No other render may keep its checkpoint there meanwhile.
    ///
    /// # Errors
    /// Where another render does so, or the file cannot be written.
    pub fn take(path: &Path, seconds: f64, watch: &Watch<'_>) -> Result<Self> {
        files::check_writable(path)?;
        let lock = CheckpointLock::take(path)?;
        if lock.is_none() {
            watch.warn(&format!(
                "{}: its disk keeps no locks; see that no other render has this checkpoint",
                path.display()
            ));
        }
        // An interval that is too long for a `Duration` never ends.
        let every = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        Ok(Self { path: path.to_path_buf(), every, lock })
    }

    /// Lets other renders go on with the file.
    fn release(&mut self) {
        self.lock = None;
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        if self.lock.is_none() {
            self.lock = CheckpointLock::take(&self.path)?;
        }
        checkpoint.write(&self.path)
    }
}

/// Least ratio of the time between two readings of the state to the time of one reading. Where steps are short, several steps
/// pass between two readings.
const READING_SHARE: u32 = 20;

/// The checkpoints of one render.
///
/// A checkpoint holds steps of the full length only. A signal in the middle of a step loses that step. A resumed render has the
/// bits of a render that was never interrupted.
pub(super) struct Checkpoints {
    file: CheckpointFile,
    /// A checkpoint of this render with nothing rendered yet.
    template: Checkpoint,
    last: Option<Snapshot>,
    last_write: Instant,
    /// Samples per pixel in the file.
    samples_written: Option<u32>,
    /// Whether the last attempt to write the file failed.
    is_failing: bool,
}

struct Snapshot {
    checkpoint: Checkpoint,
    taken: Instant,
    cost: Duration,
}

impl Checkpoints {
    /// Checkpoints in `file` of the render that `template` describes. If the file holds the render already, `samples_written` is
    /// its number of samples per pixel.
    pub fn new(file: CheckpointFile, template: Checkpoint, samples_written: Option<u32>) -> Self {
        Self { file, template, last: None, last_write: Instant::now(), samples_written, is_failing: false }
    }

    /// Whether they are kept in the file at `path`.
    pub fn is_in(&self, path: &Path) -> bool {
        let file = |path: &Path| files::written_file(path).ok();
        file(path).is_some() && file(path) == file(&self.file.path)
    }

    /// Forgets what was read back, because the render begins again with other settings. The file stays until it is written
    /// again.
    pub fn begin_again(&mut self, settings: &Settings) {
        self.template.settings = settings.clone();
        (self.last, self.samples_written) = (None, None);
    }

    /// Notes the samples of earlier renders that the guide has learned from.
    pub fn begin_with_guide(&mut self, samples: &SampleRanges) {
        self.template.record.guide_samples = samples.clone();
    }

    /// Reads the state back before a step of `samples` samples per pixel, if enough time has passed or the step is shorter than
    /// usual. A checkpoint cannot hold a shorter step.
    pub fn before_step(&mut self, fleet: &Fleet, history: &History, samples: u32) -> Result<()> {
        let is_due = self.last.as_ref().is_none_or(|last| last.taken.elapsed() >= last.cost * READING_SHARE);
        let is_last = samples < fleet.first().samples_of_next_step();
        if is_due || is_last { self.take(fleet, history) } else { Ok(()) }
    }

    /// Writes the file after a step if the interval has passed. Of several failures in a row, only the first is returned. After a
    /// failure the next attempt waits for the whole interval.
    pub fn after_step(&mut self, fleet: &Fleet, history: &History) -> Result<()> {
        if self.last_write.elapsed() < self.file.every {
            return Ok(());
        }
        let written = self.take(fleet, history).and_then(|()| self.write());
        let is_news = !self.is_failing;
        (self.last_write, self.is_failing) = (Instant::now(), written.is_err());
        if is_news { written } else { Ok(()) }
    }

    /// Writes the last state that a checkpoint can hold, at the end of a render. Other renders may then go on with the file. Of a
    /// lost device, the last state is the one that was read back before.
    pub fn finish(&mut self, fleet: &Fleet, history: &History, is_lost: bool) -> Result<()> {
        let taken = if is_lost { Ok(()) } else { self.take(fleet, history) };
        let written = taken.and(self.write());
        self.file.release();
        written
    }

    /// Reads the state back, unless it is known already or a step was cut short.
    fn take(&mut self, fleet: &Fleet, history: &History) -> Result<()> {
        let samples = fleet.first().samples_done();
        let is_known = self.last.as_ref().is_some_and(|last| last.checkpoint.state.samples_done == samples);
        if is_known || !fleet.first().is_at_step_end() {
            return Ok(());
        }
        let begin = Instant::now();
        // The old snapshot stays until the new one is complete, because the device may be lost.
        let state = fleet.state()?;
        let record = Record { history: history.clone(), ..self.template.record.clone() };
        let checkpoint = Checkpoint { record, state, ..self.template.clone() };
        self.last = Some(Snapshot { checkpoint, taken: Instant::now(), cost: begin.elapsed() });
        Ok(())
    }

    /// Writes the last state that was read back.
    fn write(&mut self) -> Result<()> {
        let Some(Snapshot { checkpoint, .. }) = &self.last else { return Ok(()) };
        let samples = Some(checkpoint.state.samples_done);
        if self.samples_written != samples {
            self.file.write(checkpoint)?;
            self.samples_written = samples;
        }
        Ok(())
    }
}
