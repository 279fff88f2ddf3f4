//! Sessions: the steps of a render until a limit ends it.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::denoise::Denoiser;
use crate::film::ranges::SampleRanges;
use crate::film::{Denoised, Picture};
use crate::fleet::Fleet;
use crate::gpu::Context;
use crate::image::{Image, metrics};
use crate::renderer::learned_guide::GuideState;
use crate::renderer::{RenderState, StepReport};
use crate::scene::LoadOptions;
use crate::session::checkpoints::Checkpoints;
use crate::session::files::PictureFiles;
use crate::session::history::History;
use crate::session::identity;
use crate::session::length::Length;
use crate::session::profile::Summary;
use crate::session::profiler::Profiler;
use crate::session::progress::{Ending, Event, Progress, Watch};
use crate::session::safety_copy::SafetyCopy;
use crate::session::statistics::{SetupTimes, StepStatistics};
use crate::settings::Settings;
use crate::{Error, Result};

/// A render from its start to its end.
///
/// A session takes steps until enough samples or seconds have passed, noise is low enough, or its caller stops it. It keeps
/// checkpoints, a safety copy of the picture, statistics and times, and writes the files that its [`Options`](crate::Options)
/// name.
///
/// ```no_run
/// use lodestar::{Options, Session};
/// let mut session = Session::open("scene.xml", &Options::new())?;
/// session.step(16)?;
/// let preview = session.picture()?;
/// session.step(48)?;
/// # Ok::<(), lodestar::Error>(())
/// ```
pub struct Session {
    pub(super) context: Arc<Context>,
    pub(super) fleet: Fleet,
    pub(super) settings: Settings,
    pub(super) length: Length,
    pub(super) history: History,
    pub(super) origin: Origin,
    pub(super) subject: Subject,
    /// The picture that errors are measured against.
    pub(super) reference: Option<Image>,
    pub(super) output: Output,
    pub(super) checkpoints: Option<Checkpoints>,
    pub(super) profiler: Option<Profiler>,
    /// Times of all dispatches. They are set when the trace is written.
    pub(super) profile: Option<Summary>,
    /// Safety copy of the picture. It is set when the device is lost.
    pub(super) rescued: Option<Picture>,
}

/// What a session begins again from, where a driver ends a loop of a kernel early.
#[derive(Default)]
pub(super) struct Origin {
    /// State and history of the checkpoint that a resumed render came from.
    pub checkpoint: Option<(RenderState, History)>,
    /// The guide that the render began with.
    pub guide: Option<GuideState>,
    /// Samples per pixel at which calls of [`Session::step`] ended, and steps with them.
    pub cuts: Vec<u32>,
}

impl Origin {
    /// Most samples of the next step, so that no step crosses the end of a call.
    fn samples_to_cut(&self, samples_done: u32) -> u32 {
        let cut = self.cuts.iter().find(|&&cut| cut > samples_done);
        cut.map_or(u32::MAX, |cut| cut - samples_done)
    }
}

/// The scene and the kernels of a render.
pub(super) struct Subject {
    pub scene_name: String,
    pub scene_path: PathBuf,
    pub scene_hash: String,
    /// File of the scene, with the choices with which it is read; `None` for a scene made in memory.
    pub source: Option<(PathBuf, LoadOptions)>,
    /// Files that stand in for built-in kernels, with their hashes.
    pub kernels: Vec<String>,
    pub times: SetupTimes,
}

/// Files of the picture and of its statistics, and the time of the last writing.
pub(super) struct Output {
    pub pictures: PictureFiles,
    /// Seconds between two writings of the unfinished picture.
    pub write_every: Option<f64>,
    pub statistics: Option<PathBuf>,
    /// The denoiser of the last picture, if one is wanted.
    pub denoiser: Option<Denoiser>,
    pub safety_copy: SafetyCopy,
    pub last_write: Instant,
    /// Whether the last writing succeeded.
    pub is_writable: bool,
}

impl Session {
    /// Takes `samples` more samples per pixel, whatever the length of the render. The guide's schedule splits them into steps, so
    /// that the guide learns between steps. If `samples` cuts a step short, the steps after it differ from the steps of one longer
    /// call. This function writes no files; [`Session::run`] does.
    ///
    /// # Errors
    /// Where the device is lost or a result would be wrong.
    pub fn step(&mut self, samples: u32) -> Result<Progress> {
        self.step_watched(samples, &Watch::silent())
    }

    /// Takes samples like [`Session::step`] and tells `watch` every event. A step that `watch` stops is the last one.
    ///
    /// # Errors
    /// Where [`Session::step`] fails.
    pub fn step_watched(&mut self, samples: u32, watch: &Watch<'_>) -> Result<Progress> {
        let most = u32::MAX - self.settings.sample_offset.unwrap_or(0);
        let end = self.fleet.first().samples_done().saturating_add(samples).min(most);
        while self.can_step() && self.fleet.first().samples_done() < end {
            self.advance(end - self.fleet.first().samples_done(), None, watch)?;
        }
        self.origin.cuts.push(self.fleet.first().samples_done());
        Ok(self.progress())
    }

    /// Takes the next step of the render. Returns false, without a step, where a limit is reached or `watch` stops the render.
    /// A caller that takes all steps by this function may use the session between them; [`Session::run_watched`] then writes the
    /// files.
    ///
    /// # Errors
    /// Where the device is lost or a result would be wrong.
    pub fn next_step(&mut self, watch: &Watch<'_>) -> Result<bool> {
        if self.is_done(watch) {
            return Ok(false);
        }
        self.advance(self.samples_left(), self.deadline(), watch)?;
        Ok(true)
    }

    /// Samples per pixel of the next step by the guide's schedule.
    pub fn samples_of_next_step(&self) -> u32 {
        self.fleet.first().samples_of_next_step()
    }

    /// Renders to the end and writes the files. `on_step` is called after every step; `Break` ends the render.
    ///
    /// # Errors
    /// Where the device is lost, a result would be wrong, or a file cannot be written.
    pub fn run(&mut self, on_step: impl FnMut(&Self) -> ControlFlow<()>) -> Result<()> {
        self.run_watched(&Watch::silent(), on_step)
    }

    /// Renders like [`Session::run`] and tells `watch` every event.
    ///
    /// # Errors
    /// Where [`Session::run`] fails.
    pub fn run_watched(&mut self, watch: &Watch<'_>, mut on_step: impl FnMut(&Self) -> ControlFlow<()>) -> Result<()> {
        let mut is_broken = false;
        let mut on_step = |session: &Self| {
            let flow = on_step(session);
            is_broken |= flow.is_break();
            flow
        };
        let rendered = self.render(watch, &mut on_step);
        let ending = self.ending(is_broken || (watch.stop)());
        watch.tell(Event::Rendered);
        let finished = self.finish(rendered, watch);
        let ending = if finished.is_ok() { ending } else { Ending::Failed };
        watch.tell(Event::Ended(ending, &self.progress()));
        finished
    }

    /// The picture so far. If the device was lost during [`Session::run`], this is the last safety copy of the picture.
    ///
    /// # Errors
    /// Where the device is lost and there is no copy.
    pub fn picture(&self) -> Result<Picture> {
        self.rescued.clone().map_or_else(|| self.fleet.picture(), Ok)
    }

    /// Progress of the render.
    pub fn progress(&self) -> Progress {
        let samples = self.fleet.first().samples_done();
        Progress {
            samples,
            seconds: self.history.seconds,
            paths: self.history.paths,
            light_hit_rate: self.history.steps.last().map_or(0.0, |step| step.light_hit_rate),
            noise: self.fleet.first().noise(),
            fraction: self.length.fraction(samples, self.history.seconds),
            length: self.length,
        }
    }

    /// The steps so far.
    #[doc(hidden)]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Writes the unfinished picture into its files, without denoising it.
    ///
    /// # Errors
    /// Where the device is lost or a file cannot be written.
    #[doc(hidden)]
    pub fn write_now(&self, watch: &Watch<'_>) -> Result<()> {
        self.write_pictures(&self.picture()?, None, watch)
    }

    /// The settings of the render.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The device that renders.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Times of all dispatches, after the end of a render with [`OutputFiles::profile`](crate::session::OutputFiles::profile).
    pub fn profile(&self) -> Option<&Summary> {
        self.profile.as_ref()
    }

    /// Takes steps until a limit is reached or the caller stops the render. The time in which pictures are written or measured does
    /// not count.
    fn render(&mut self, watch: &Watch<'_>, on_step: &mut dyn FnMut(&Self) -> ControlFlow<()>) -> Result<()> {
        while self.next_step(watch)? {
            if on_step(self).is_break() {
                break;
            }
            self.write_if_due(watch)?;
        }
        Ok(())
    }

    /// Takes one step of at most `most` samples per pixel, then updates the safety copy and the checkpoint.
    ///
    /// Where the driver ends a loop of a kernel early, the render begins again with fewer samples per dispatch.
    fn advance(&mut self, most: u32, deadline: Option<Instant>, watch: &Watch<'_>) -> Result<()> {
        let most = most.min(self.origin.samples_to_cut(self.fleet.first().samples_done()));
        let step = match self.take_step(most, deadline, watch) {
            Err(Error::LoopCut(_)) if self.settings.samples_per_dispatch > 1 => return self.begin_again(watch),
            step => step.map_err(|error| error.noting(&self.history.last_good_step()))?,
        };
        self.history.steps.push(step);
        watch.tell(Event::Step(&self.progress()));
        let copied = self.output.safety_copy.after_step(&self.fleet);
        copied.map_err(|error| error.noting(&self.history.last_good_step()))?;
        if !self.fleet.first().is_stopped()
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
        let samples_before = self.fleet.first().samples_done();
        let samples = self.fleet.first().samples_of_next_step().min(most);
        self.keep(|checkpoints, fleet, history| checkpoints.before_step(fleet, history, samples))?;
        let stop = || (watch.stop)() || deadline.is_some_and(|deadline| Instant::now() >= deadline);
        let report = self.fleet.step(samples, &stop)?;

        if let Some(profiler) = &mut self.profiler {
            profiler.note(&report);
        }
        self.history.seconds += report.seconds;
        self.history.counts.add(&report.counts);
        let spp = self.fleet.first().samples_done() - samples_before;
        let paths = self.paths_of(&report, spp)?;
        self.history.paths = self.history.paths.saturating_add(paths);
        let mut step = StepStatistics::new(spp.into(), paths, self.pixels(), report.seconds, &report.counts);
        // Errors are measured after steps 1, 2, 4, 8, ..., because error curves have logarithmic axes.
        if (self.history.steps.len() + 1).is_power_of_two() {
            step.errors = self.measure(&self.fleet.picture()?)?;
        }
        Ok(step)
    }

    /// Calls `act` with the checkpoints, if there are any.
    pub(super) fn keep(&mut self, act: impl FnOnce(&mut Checkpoints, &Fleet, &History) -> Result<()>) -> Result<()> {
        let Self { checkpoints, fleet, history, .. } = self;
        checkpoints.as_mut().map_or(Ok(()), |checkpoints| act(checkpoints, fleet, history))
    }

    /// Number of paths of the step that has just ended. A step that was cut short has sampled some pixels more often than others.
    fn paths_of(&self, report: &StepReport, spp: u32) -> Result<u64> {
        if report.complete {
            return Ok(u64::from(spp) * report.pixels);
        }
        let sample_count = self.fleet.picture()?.sample_count;
        Ok(sample_count.into_iter().map(u64::from).sum::<u64>().saturating_sub(self.history.paths))
    }

    fn is_done(&self, watch: &Watch<'_>) -> bool {
        !self.can_step()
            || (watch.stop)()
            || self.samples_left() == 0
            || self.length.seconds.is_some_and(|limit| self.history.seconds >= limit)
    }

    /// Whether another step may follow: no step was stopped, and some pixels are still noisy.
    fn can_step(&self) -> bool {
        !self.fleet.first().is_stopped() && self.fleet.first().sampled_pixels() > 0
    }

    /// Reason why no step follows.
    fn ending(&self, is_stopped: bool) -> Ending {
        match () {
            () if self.samples_left() == 0 => Ending::Samples,
            () if self.fleet.first().sampled_pixels() == 0 => Ending::Noise,
            () if is_stopped || self.length.seconds.is_none() => Ending::Stopped,
            () => Ending::Time,
        }
    }

    fn samples_left(&self) -> u32 {
        self.length.samples_left(&self.settings, self.fleet.first().samples_done())
    }

    fn deadline(&self) -> Option<Instant> {
        let time_left = self.length.seconds.map(|limit| (limit - self.history.seconds).max(0.0));
        // A limit that is too far away for an `Instant` is no limit.
        let time_left = time_left.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        time_left.and_then(|time_left| Instant::now().checked_add(time_left))
    }

    /// Number of pixels of the rendered window.
    pub(super) fn pixels(&self) -> u64 {
        let window = self.settings.window();
        u64::from(window.width) * u64::from(window.height)
    }

    /// Error of `picture`, if there is a reference.
    pub(super) fn measure(&self, picture: &Picture) -> Result<Option<metrics::Metrics>> {
        let reference = self.reference.as_ref();
        reference.map(|reference| metrics::compare(&picture.image(), reference)).transpose()
    }

    /// Name of the device with its driver, as checkpoints and pictures have it.
    pub(super) fn device_name(&self) -> String {
        device_name(&self.context)
    }

    /// Writes the unfinished picture if its interval has passed.
    fn write_if_due(&mut self, watch: &Watch<'_>) -> Result<()> {
        let elapsed = self.output.last_write.elapsed().as_secs_f64();
        let is_due = self.output.write_every.is_some_and(|every| elapsed >= every);
        if !is_due || self.is_done(watch) {
            return Ok(());
        }
        let written = self.write_pictures(&self.fleet.picture()?, None, watch);
        if let (Err(error), true) = (&written, self.output.is_writable) {
            // The render goes on, because the folder may be back or the disk may have room when it ends.
            watch.warn(&format!("{error}; the render goes on"));
        }
        (self.output.last_write, self.output.is_writable) = (Instant::now(), written.is_ok());
        Ok(())
    }

    /// Names and values that the header of a picture's EXR file holds: the settings, the sample numbers, the time, the device and
    /// the scene. `lodestar merge` needs them.
    pub fn attributes(&self, picture: &Picture) -> Vec<(String, String)> {
        let Subject { scene_hash, scene_path, kernels, .. } = &self.subject;
        // Where the device has chosen the traversal, the picture names the one that it has.
        let settings = Settings { traversal: self.fleet.first().traversal(), ..self.settings.clone() };
        let mut attributes = identity::attributes(scene_hash, &settings);
        attributes.extend([
            ("sample_ranges".into(), SampleRanges::of_picture(picture, &self.settings).to_string()),
            ("spp".into(), most_samples(picture).to_string()),
            ("seconds".into(), format!("{:.3}", self.history.seconds)),
            ("device".into(), self.device_name()),
            ("scene".into(), scene_path.display().to_string()),
        ]);
        if !kernels.is_empty() {
            attributes.push(("replaced_kernels".into(), kernels.join(", ")));
        }
        attributes
    }

    /// Writes the picture's files.
    pub(super) fn write_pictures(
        &self,
        picture: &Picture,
        denoised: Option<&Denoised>,
        watch: &Watch<'_>,
    ) -> Result<()> {
        let attributes = self.attributes(picture);
        self.output.pictures.write(picture, denoised, &attributes, &|path| watch.tell(Event::Written(path)))
    }
}

/// Name of a device with its driver.
pub(super) fn device_name(context: &Context) -> String {
    let device = context.device();
    format!("{} ({})", device.name, device.driver_info)
}

/// Largest number of samples of a pixel. Pixels have fewer where noise has ended them, or where the last step was cut short.
fn most_samples(picture: &Picture) -> u32 {
    picture.sample_count.iter().copied().max().unwrap_or(0)
}
