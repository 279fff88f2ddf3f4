//! `render --profile`.

use std::path::PathBuf;
use std::sync::Arc;

use lodestar::gpu::Context;
use lodestar::renderer::StepReport;
use lodestar::session::profile::{Profile, Step};
use lodestar::{Result, files};

use super::print_line;

/// Collects the times of a render and writes them at its end.
pub struct Profiler {
    path: PathBuf,
    context: Arc<Context>,
    profile: Profile,
}

impl Profiler {
    /// Times all that `context` does from now on.
    pub fn start(path: PathBuf, context: &Arc<Context>) -> Self {
        let profile = Profile::new(context.record_timings(), &context.device().name);
        Self { path, context: Arc::clone(context), profile }
    }

    /// Takes note of a step that has just ended.
    pub fn note(&mut self, report: &StepReport) {
        self.profile.add(Step {
            samples: report.samples,
            rays: report.counts.rays,
            seconds: report.seconds,
            submissions: self.context.take_timings(),
        });
    }

    /// Writes the trace and prints the table.
    pub fn finish(&self) -> Result<()> {
        let trace = self.profile.trace();
        files::write_whole(&self.path, |writer| Ok(serde_json::to_writer(writer, &trace)?))?;
        print_line(self.profile.summary().table().trim_end())
    }
}
