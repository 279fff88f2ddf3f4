//! Timing a render for `--profile`.

use std::path::PathBuf;
use std::sync::Arc;

use crate::gpu::Context;
use crate::renderer::StepReport;
use crate::session::profile::{Profile, ProfiledStep, Summary};
use crate::{Result, files};

/// Collects the times of a render and writes them at its end. Its context is timed only while it lives.
pub(super) struct Profiler {
    path: PathBuf,
    context: Arc<Context>,
    profile: Profile,
}

impl Profiler {
    /// Times everything that `context` does from now on.
    pub fn start(path: PathBuf, context: &Arc<Context>) -> Self {
        let profile = Profile::new(context.record_timings(), &context.device().name);
        Self { path, context: Arc::clone(context), profile }
    }

    /// Adds a step that has just ended.
    pub fn note(&mut self, report: &StepReport) {
        self.profile.add(ProfiledStep {
            samples: report.samples,
            rays: report.counts.rays,
            seconds: report.seconds,
            submissions: self.context.take_timings(),
        });
    }

    /// Writes the trace and returns its summary.
    pub fn write(&self) -> Result<Summary> {
        let trace = self.profile.trace();
        files::write_whole(&self.path, |writer| Ok(serde_json::to_writer(writer, &trace)?))?;
        Ok(self.profile.summary())
    }
}

impl Drop for Profiler {
    /// Other renders may go on in the context. They must not be timed: their record would grow without end.
    fn drop(&mut self) {
        self.context.stop_timings();
    }
}
