//! A render that has begun: its steps until a limit ends it.
//!
//! | what belongs to | fields |
//! |---|---|
//! | the scene | `subject`, and the geometry in `fleet` |
//! | the guide | `origin.guide`, and the grids in `fleet` |
//! | the film | `settings`, `length`, `history`, `output`, `checkpoints`, and the film in `fleet` |
//!
//! A render that changes its camera begins the film anew and keeps the other two. One that changes its scene keeps the guide.

mod another_scene;
mod another_view;
mod continuation;
mod report;

use std::cell::Cell;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::film::Picture;
use crate::fleet::Fleet;
use crate::gpu::Context;
use crate::image::metrics::Metrics;
use crate::renderer::{Renderer, StepReport};
use crate::session::checkpoints::Checkpoints;
use crate::session::history::History;
use crate::session::length::Length;
use crate::session::origin::Origin;
use crate::session::output::Output;
use crate::session::profile::Summary;
use crate::session::profiler::Profiler;
use crate::session::progress::{Ending, Event, Watch};
use crate::session::safety_copy::CopiedPicture;
use crate::session::source::Source;
use crate::session::statistics::StepStatistics;
use crate::session::subject::Subject;
use crate::settings::Settings;
use crate::{Error, Result};

/// A render that has begun.
pub(super) struct Running {
    context: Arc<Context>,
    fleet: Fleet,
    settings: Settings,
    length: Length,
    history: History,
    origin: Origin,
    subject: Subject,
    output: Output,
    checkpoints: Option<Checkpoints>,
    profiler: Option<Profiler>,
}

impl Running {
    /// A render without samples.
    pub fn new(
        context: Arc<Context>,
        fleet: Fleet,
        settings: Settings,
        length: Length,
        subject: Subject,
        output: Output,
        profiler: Option<Profiler>,
    ) -> Self {
        let (history, origin, checkpoints) = (History::default(), Origin::default(), None);
        Self { context, fleet, settings, length, history, origin, subject, output, checkpoints, profiler }
    }

    /// Takes `samples` more samples per pixel in whole steps of the schedule, the last one perhaps shorter.
    pub fn take_samples(&mut self, samples: u32, watch: &Watch<'_>) -> Result<()> {
        let most = u32::MAX - self.settings.sample_offset.unwrap_or(0);
        let end = self.samples_done().saturating_add(samples).min(most);
        while self.can_step() && self.samples_done() < end {
            self.advance(end - self.samples_done(), None, watch)?;
        }
        self.origin.cuts.push(self.samples_done());
        Ok(())
    }

    /// Takes the next step. Returns false, without a step, where a limit is reached or `watch` stops the render.
    pub fn next_step(&mut self, watch: &Watch<'_>) -> Result<bool> {
        if self.is_done(watch) {
            return Ok(false);
        }
        self.advance(self.samples_left(), self.deadline(), watch)?;
        Ok(true)
    }

    /// Takes one step of at most `most` samples per pixel, then updates the safety copy and the checkpoint.
    ///
    /// Where the driver ends a loop of a kernel early, the render begins again with fewer samples per dispatch.
    fn advance(&mut self, most: u32, deadline: Option<Instant>, watch: &Watch<'_>) -> Result<()> {
        let most = most.min(self.origin.samples_to_cut(self.samples_done()));
        let step = match self.take_step(most, deadline, watch) {
            Err(Error::LoopCut(_)) if self.settings.samples_per_dispatch > 1 => return self.begin_again(watch),
            step => step.map_err(|error| error.noting(&self.history.last_good_step()))?,
        };
        self.history.steps.push(step);
        watch.tell(Event::Step(&self.progress()));
        let copied = self.output.safety_copy.after_step(&self.fleet);
        copied.map_err(|error| error.noting(&self.history.last_good_step()))?;
        if !self.renderer().is_stopped()
            && let Err(error) = self.keep(|checkpoints, fleet, history| checkpoints.after_step(fleet, history))
        {
            if error.is_loss() {
                return Err(error.noting(&self.history.last_good_step()));
            }
            watch.warn(&format!("{error}; the render goes on"));
        }
        Ok(())
    }

    /// Begins the render again with half as many samples per dispatch: the picture has the bits of a render that began so. The
    /// time that has passed still counts.
    fn begin_again(&mut self, watch: &Watch<'_>) -> Result<()> {
        let (before, now) = (self.settings.samples_per_dispatch, self.settings.samples_per_dispatch / 2);
        watch.warn(&format!(
            "the driver of {} ended a loop of a kernel before its end, so the render begins again with {now} in place of \
             {before} samples per dispatch",
            self.context.device().name
        ));
        self.settings.samples_per_dispatch = now;
        let seconds = self.history.seconds;
        let (state, history) = match &self.origin.checkpoint {
            Some((state, history)) => (Some(state), history.clone()),
            None => (None, History::default()),
        };
        self.fleet.begin_again(now, state)?;
        if let Some(guide) = &self.origin.guide {
            self.fleet.begin_with_guide_state(guide)?;
        }
        self.history = History { seconds, ..history };
        self.output.safety_copy.take();
        let settings = &self.settings;
        self.checkpoints.iter_mut().for_each(|checkpoints| checkpoints.begin_again(settings));
        Ok(())
    }

    fn take_step(&mut self, most: u32, deadline: Option<Instant>, watch: &Watch<'_>) -> Result<StepStatistics> {
        let samples_before = self.samples_done();
        let samples = self.samples_of_next_step().min(most);
        self.keep(|checkpoints, fleet, history| checkpoints.before_step(fleet, history, samples))?;
        let (before, begun, last_told) = (self.progress(), Instant::now(), Cell::new(0));
        let stop = || {
            let seconds = begun.elapsed().as_secs_f64();
            // The first dispatch of a step has no second behind it.
            if last_told.replace(seconds as u64) < seconds as u64 {
                watch.tell(Event::InStep(&before.after(seconds)));
            }
            (watch.stop)() || deadline.is_some_and(|deadline| Instant::now() >= deadline)
        };
        let report = self.fleet.step(samples, &stop)?;

        if let Some(profiler) = &mut self.profiler {
            profiler.note(&report);
        }
        self.history.seconds += report.seconds;
        self.history.counts.add(&report.counts);
        let spp = self.samples_done() - samples_before;
        let paths = self.paths_of(&report, spp)?;
        self.history.paths = self.history.paths.saturating_add(paths);
        let mut step = StepStatistics::new(spp.into(), paths, self.pixels(), report.seconds, &report.counts);
        // Errors are measured after steps 1, 2, 4, 8, ..., because error curves have logarithmic axes.
        if (self.history.steps.len() + 1).is_power_of_two() {
            step.errors = self.measured()?;
        }
        Ok(step)
    }

    /// Error of the picture so far, if there is a reference.
    fn measured(&self) -> Result<Option<Metrics>> {
        if self.output.measures() { self.output.measure(&self.source()?) } else { Ok(None) }
    }

    /// Calls `act` with the checkpoints, if there are any.
    fn keep(&mut self, act: impl FnOnce(&mut Checkpoints, &Fleet, &History) -> Result<()>) -> Result<()> {
        let Self { checkpoints, fleet, history, .. } = self;
        checkpoints.as_mut().map_or(Ok(()), |checkpoints| act(checkpoints, fleet, history))
    }

    /// Number of paths of the step that has just ended. A step that was cut short has sampled some pixels more often than others.
    fn paths_of(&self, report: &StepReport, spp: u32) -> Result<u64> {
        if report.complete {
            return Ok(u64::from(spp) * report.pixels);
        }
        Ok(self.fleet.samples_in_film()?.saturating_sub(self.history.paths))
    }
}

/// Limits of a render.
impl Running {
    fn is_done(&self, watch: &Watch<'_>) -> bool {
        !self.can_step()
            || (watch.stop)()
            || self.samples_left() == 0
            || self.length.seconds.is_some_and(|limit| self.history.seconds >= limit)
    }

    /// Whether another step may follow: no step was stopped, and some pixels are still noisy.
    fn can_step(&self) -> bool {
        !self.renderer().is_stopped() && self.renderer().sampled_pixels() > 0
    }

    /// Reason why no step follows.
    pub fn ending(&self, is_stopped: bool) -> Ending {
        match () {
            () if self.samples_left() == 0 => Ending::Samples,
            () if self.renderer().sampled_pixels() == 0 => Ending::Noise,
            () if is_stopped || self.length.seconds.is_none() => Ending::Stopped,
            () => Ending::Time,
        }
    }

    fn samples_left(&self) -> u32 {
        self.length.samples_left(&self.settings, self.samples_done())
    }

    fn deadline(&self) -> Option<Instant> {
        let time_left = self.length.seconds.map(|limit| (limit - self.history.seconds).max(0.0));
        // A limit that is too far away for an `Instant` is no limit.
        let time_left = time_left.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        time_left.and_then(|time_left| Instant::now().checked_add(time_left))
    }

    /// Samples per pixel of the next step by the guide's schedule.
    pub fn samples_of_next_step(&self) -> u32 {
        self.renderer().samples_of_next_step()
    }

    /// Samples per pixel so far.
    pub fn samples_done(&self) -> u32 {
        self.renderer().samples_done()
    }
}

/// What the end of a render needs.
impl Running {
    /// The last safety copy of the picture, which is then no longer kept.
    pub fn take_safety_copy(&mut self) -> Option<CopiedPicture> {
        self.output.safety_copy.take()
    }

    /// Writes the last checkpoint, if one is kept.
    pub fn keep_last(&mut self, is_lost: bool) -> Result<()> {
        self.keep(|checkpoints, fleet, history| checkpoints.finish(fleet, history, is_lost))
    }

    /// Writes the trace of all dispatches if the caller wants one.
    pub fn write_profile(&self) -> Result<Option<Summary>> {
        self.profiler.as_ref().map(Profiler::write).transpose()
    }

    /// The picture so far.
    pub fn picture(&self) -> Result<Picture> {
        self.fleet.picture()
    }

    /// The picture so far, for files. A large one is not read back as a whole.
    pub fn source(&self) -> Result<Source<'_>> {
        Source::of(&self.fleet, self.output.denoises())
    }

    /// The first device, which has the guide and the numbers of all.
    pub fn renderer(&self) -> &Renderer {
        self.fleet.first()
    }

    pub fn output(&self) -> &Output {
        &self.output
    }

    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    pub fn history(&self) -> &History {
        &self.history
    }
}
