//! `lodestar render`: loads, renders step by step, shows progress, and writes what was asked for.

use std::collections::HashSet;
use std::panic::resume_unwind;
use std::process::ExitCode;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use lodestar::encode::bvh::Bvh;
use lodestar::encode::surfaces::Surfaces;
use lodestar::film::Picture;
use lodestar::film::ranges::SampleRanges;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::image::{Image, metrics};
use lodestar::renderer::{RenderState, Renderer, StepReport};
use lodestar::scene::{self, LoadOptions, LoadProgress};
use lodestar::session::checkpoint::{Checkpoint, SceneSource};
use lodestar::session::identity::{self, Identity};
use lodestar::settings::{Execution, Settings};
use lodestar::{Error, Result, files};

use super::interrupt::Interrupt;
use super::keeper::Keeper;
use super::kernel_dir::KernelDir;
use super::outputs::{Outputs, read_reference, whole_path};
use super::profile::Profiler;
use super::progress::{Loading, Progress, Status};
use super::render_args::{DeviceArgs, RenderArgs};
use super::report;
use super::safety_copy::{Copied, SafetyCopy};
use super::stats::{SetupTimes, Stats, Step, Totals, Versions, peak_resident_bytes};
use super::task::{Before, Beginning, CheckpointFile, History, JobRecord, Length, Start, Task};

/// Renders as `args` say.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let checkpoint = args.checkpoint.clone().map(|path| CheckpointFile::new(path, args.checkpoint_every));
    let task = Task {
        scene: args.scene.clone(),
        define: args.define.clone(),
        files: args.files.clone(),
        device: args.device.clone(),
        checkpoint,
    };
    render(&task, Start::New(args))
}

/// Renders, from the start or from a checkpoint. Bad input and unwritable outputs are found before any time is spent.
pub fn render(task: &Task, start: Start) -> Result<ExitCode> {
    let begin = Instant::now();
    let interrupt = Interrupt::catch()?;
    let loading = Loading::new(task.files.quiet);
    let options = LoadOptions { defines: task.define.clone() };
    let show = |progress: LoadProgress| loading.show(&progress.to_string());
    let context_options = ContextOptions { device: task.device.device(), validate: task.device.validate };
    // Drivers take a while to start.
    let (context, loaded) = thread::scope(|scope| {
        let context = scope.spawn(|| Context::new(&context_options));
        let loaded = timed(|| scene::load_with_progress(&task.scene, &options, &show));
        (context.join(), loaded)
    });
    let (mut scene, load_seconds) = loaded?;
    loading.interleave(|| warn(&scene.warnings));
    let scene_hash = scene::fingerprint(&scene)?;
    let Beginning { settings, length, before, warning } = start.begin(&scene, &scene_hash, &task.device)?;
    loading.interleave(|| warn(warning.as_slice()));
    let settings = with_replaced_kernels(settings, &task.device);
    let outputs = Outputs::new(&task.files, before.as_ref().map(|before| &before.outputs), &scene)?;
    if let Some(file) = &task.checkpoint {
        file.check(before.is_some(), &Identity::of_render(&scene_hash, &settings))?;
    }
    let kernels = loading.interleave(|| KernelDir::load(task.device.kernel_dir.as_deref()))?;
    let reference = task.files.reference.as_deref().map(|path| read_reference(path, &settings)).transpose()?;
    let context = context.unwrap_or_else(|panic| resume_unwind(panic))?;
    loading.show(&format!("building the BVH of {} primitives", scene.primitives.len()));
    let prepare = || rayon::join(|| Bvh::build(&scene.primitives), || Surfaces::new(&scene));
    let ((bvh, surfaces), bvh_seconds) = timed(|| Ok(prepare()))?;
    // From here on the device's copy is the one that is used.
    let primitive_count = std::mem::take(&mut scene.primitives).len();
    loading.show("building the kernels");
    let registry = kernels.registry();
    let build = || Renderer::with_surfaces(&context, &scene, surfaces, &bvh, &settings, registry);
    let (renderer, pipeline_seconds) = timed(build)?;
    drop(bvh);
    drop(loading);
    kernels.warn_of_unused(renderer.back_end());

    let setup_seconds = begin.elapsed().as_secs_f64();
    let times = SetupTimes { load_seconds, bvh_seconds, pipeline_seconds, setup_seconds, primitive_count };
    let film = Film { renderer, reference, outputs };
    let subject = Subject { task, scene_name: &scene.name, scene_hash };
    let mut job = Job::new(subject, &context, settings, length, film, &interrupt);
    job.kernels = kernels.replaced(job.film.renderer.back_end());
    job.begin(before)?;
    let rendered = job.render();
    let finished = job.finish(rendered, times).and(job.profiler.as_ref().map_or(Ok(()), Profiler::finish));
    warn_of_nonfinite(job.history.counts.nonfinite);
    finished.and(report_validation(&context))?;
    Ok(interrupt.exit_code())
}

/// An edited kernel is to be the one that runs.
fn with_replaced_kernels(mut settings: Settings, device: &DeviceArgs) -> Settings {
    if device.kernel_dir.is_some() && settings.execution == Execution::Auto {
        settings.execution = Execution::Megakernel;
    }
    settings
}

/// A render under way.
struct Job<'a> {
    subject: Subject<'a>,
    context: &'a Arc<Context>,
    interrupt: &'a Interrupt,
    settings: Settings,
    length: Length,
    film: Film,
    keeper: Option<Keeper>,
    safety_copy: SafetyCopy,
    profiler: Option<Profiler>,
    /// The files that stand in for built-in kernels.
    kernels: Vec<String>,
    history: History,
}

/// What is rendered.
struct Subject<'a> {
    task: &'a Task,
    scene_name: &'a str,
    scene_hash: String,
}

/// Where the picture comes from, what it is measured against, and where it goes.
struct Film {
    renderer: Renderer,
    reference: Option<Image>,
    outputs: Outputs,
}

impl<'a> Job<'a> {
    fn new(
        subject: Subject<'a>,
        context: &'a Arc<Context>,
        settings: Settings,
        length: Length,
        film: Film,
        interrupt: &'a Interrupt,
    ) -> Self {
        let write_every = subject.task.files.write_every.and_then(|every| Duration::try_from_secs_f64(every).ok());
        let checkpoint_every = subject.task.checkpoint.as_ref().map(|file| file.every);
        let safety_copy = SafetyCopy::new(write_every.into_iter().chain(checkpoint_every));
        let profiler = subject.task.files.profile.clone().map(|path| Profiler::start(path, context));
        Self {
            subject,
            context,
            interrupt,
            settings,
            length,
            film,
            keeper: None,
            safety_copy,
            profiler,
            kernels: Vec::new(),
            history: History::default(),
        }
    }

    /// Goes on from what a checkpoint held, if there is one, and keeps checkpoints, if they are asked for.
    fn begin(&mut self, before: Option<Before>) -> Result<()> {
        let mut samples_written = None;
        if let Some(Before { history, device, kernels, state, .. }) = before {
            self.check_kernels(&kernels)?;
            if device != self.device_name() {
                let ours = self.device_name();
                report("warning", &format!("the render was begun on {device}: on {ours}, the last bits may differ"));
            }
            self.film.renderer.restore(&state)?;
            self.history = history;
            samples_written = Some(state.samples_done);
        }
        if let Some(file) = &self.subject.task.checkpoint {
            self.keeper = Some(Keeper::new(file.clone(), self.checkpoint()?, samples_written));
        }
        Ok(())
    }

    /// Other kernels would go on to other bits.
    fn check_kernels(&self, before: &[String]) -> Result<()> {
        if before == self.kernels {
            return Ok(());
        }
        let list = |kernels: &[String]| match kernels {
            [] => "the built-in kernels".to_owned(),
            kernels => kernels.join(", "),
        };
        Err(Error::Settings(format!(
            "the render was begun with {}, but would go on with {}: give the same --kernel-dir",
            list(before),
            list(&self.kernels)
        )))
    }

    /// What every checkpoint of this render says, with nothing rendered yet.
    fn checkpoint(&self) -> Result<Checkpoint<JobRecord>> {
        let Subject { task, scene_hash, .. } = &self.subject;
        let scene =
            SceneSource { path: whole_path(&task.scene)?, defines: task.define.clone(), hash: scene_hash.clone() };
        let outputs = self.film.outputs.to_whole_paths()?;
        let (kernels, history) = (self.kernels.clone(), History::default());
        let job = JobRecord { length: self.length, outputs, kernels, history };
        let (settings, device) = (self.settings.clone(), self.device_name());
        Ok(Checkpoint { scene, settings, device, job, state: RenderState::default() })
    }

    /// Steps until the samples, the time or the user's patience are used up. The clock stands while pictures are written or
    /// measured.
    fn render(&mut self) -> Result<()> {
        let Length { spp, seconds } = self.length;
        let files = &self.subject.task.files;
        let mut progress = Progress::new(files.quiet, spp.map(u64::from), seconds);
        let (mut last_write, mut is_writable) = (Instant::now(), true);
        while !self.is_done() {
            let step = self.step().map_err(|error| error.noting(&self.last_good_step()))?;
            progress.update(&self.status(&step));
            self.history.steps.push(step);
            self.safety_copy.after_step(&self.film.renderer).map_err(|error| error.noting(&self.last_good_step()))?;
            if !self.film.renderer.is_stopped()
                && let Err(error) = self.keep(|keeper, renderer, history| keeper.after_step(renderer, history))
            {
                progress.interleave(|| report("warning", &format!("{error}; the render goes on")));
            }
            let is_due = files.write_every.is_some_and(|every| last_write.elapsed().as_secs_f64() >= every);
            if is_due && !self.is_done() {
                let written = self.write_files(&self.film.renderer.picture()?, self.film.renderer.samples_done());
                if let (Err(error), true) = (&written, is_writable) {
                    // The folder may be back, or the disk have room, by the time the render ends.
                    progress.interleave(|| report("warning", &format!("{error}; the render goes on")));
                }
                (last_write, is_writable) = (Instant::now(), written.is_ok());
            }
        }
        Ok(())
    }

    fn step(&mut self) -> Result<Step> {
        let samples_before = self.film.renderer.samples_done();
        let samples = self.film.renderer.samples_of_next_step().min(self.samples_left());
        self.keep(|keeper, renderer, history| keeper.before_step(renderer, history, samples))?;
        let time_left = self.length.seconds.map(|limit| (limit - self.history.seconds).max(0.0));
        // A time too long to add up never ends.
        let time_left = time_left.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        let deadline = time_left.and_then(|time_left| Instant::now().checked_add(time_left));
        let stop = || self.interrupt.is_raised() || deadline.is_some_and(|deadline| Instant::now() >= deadline);
        let report = self.film.renderer.step(samples, &stop)?;

        if let Some(profiler) = &mut self.profiler {
            profiler.note(&report);
        }
        self.history.seconds += report.seconds;
        self.history.counts.add(&report.counts);
        let spp = self.film.renderer.samples_done() - samples_before;
        let paths = self.paths_of(&report, spp)?;
        self.history.paths += paths;
        let mut step = Step::new(spp.into(), paths, self.pixels(), report.seconds, &report.counts);
        // At steps 1, 2, 4, 8, ...: the curve is drawn over logarithmic axes.
        if (self.history.steps.len() + 1).is_power_of_two() {
            step.errors = self.measure(&self.film.renderer.picture()?)?;
        }
        Ok(step)
    }

    /// Lets the keeper do something, if there is one.
    fn keep(&mut self, act: impl FnOnce(&mut Keeper, &Renderer, &History) -> Result<()>) -> Result<()> {
        self.keeper.as_mut().map_or(Ok(()), |keeper| act(keeper, &self.film.renderer, &self.history))
    }

    /// The paths of a step that has just ended. One that was cut short has sampled some pixels more often than others.
    fn paths_of(&self, report: &StepReport, spp: u32) -> Result<u64> {
        if report.complete {
            return Ok(u64::from(spp) * report.pixels);
        }
        let sample_count = self.film.renderer.picture()?.sample_count;
        Ok(sample_count.into_iter().map(u64::from).sum::<u64>() - self.history.paths)
    }

    fn is_done(&self) -> bool {
        self.film.renderer.is_stopped()
            || self.interrupt.is_raised()
            || self.film.renderer.sampled_pixels() == 0
            || self.samples_left() == 0
            || self.length.seconds.is_some_and(|limit| self.history.seconds >= limit)
    }

    /// Samples per pixel until the render ends, or their numbers do, which have 32 bits.
    fn samples_left(&self) -> u32 {
        let most = u32::MAX - self.settings.sample_offset.unwrap_or(0);
        self.length.spp.unwrap_or(most).saturating_sub(self.film.renderer.samples_done())
    }

    fn pixels(&self) -> u64 {
        let window = self.settings.window();
        u64::from(window.width) * u64::from(window.height)
    }

    fn measure(&self, picture: &Picture) -> Result<Option<metrics::Metrics>> {
        let reference = self.film.reference.as_ref();
        reference.map(|reference| metrics::compare(&picture.image(), reference)).transpose()
    }

    fn status(&self, step: &Step) -> Status {
        let spp = self.film.renderer.samples_done();
        let by_samples = self.length.spp.map_or(0.0, |target| f64::from(spp) / f64::from(target));
        let by_time = self.length.seconds.map_or(0.0, |limit| self.history.seconds / limit);
        Status {
            spp: spp.into(),
            seconds: self.history.seconds,
            paths: self.history.paths,
            light_hit_rate: step.light_hit_rate,
            noise: self.film.renderer.noise(),
            fraction: by_samples.max(by_time).min(1.0),
        }
    }

    fn device_name(&self) -> String {
        let device = self.context.device();
        format!("{} ({})", device.name, device.driver_info)
    }

    /// Writes the picture's files, with all that is known of it in their headers.
    fn write_files(&self, picture: &Picture, samples: u32) -> Result<()> {
        let mut attributes = identity::attributes(&self.subject.scene_hash, &self.settings);
        attributes.extend([
            ("sample_ranges".into(), SampleRanges::of_picture(picture, &self.settings).to_string()),
            ("spp".into(), samples.to_string()),
            ("seconds".into(), format!("{:.3}", self.history.seconds)),
            ("device".into(), self.device_name()),
            ("scene".into(), self.subject.task.scene.display().to_string()),
        ]);
        if !self.kernels.is_empty() {
            attributes.push(("replaced_kernels".into(), self.kernels.join(", ")));
        }
        self.film.outputs.write(picture, &attributes)
    }

    /// Writes picture, checkpoint and statistics, however the render ended, and returns the first failure.
    fn finish(&mut self, rendered: Result<()>, times: SetupTimes) -> Result<()> {
        let is_lost = matches!(rendered, Err(Error::DeviceLost { .. }));
        let (picture, rendered) = self.last_picture(rendered);
        let mut errors = None;
        let written = picture.and_then(|picture| {
            picture.map_or(Ok(()), |Copied { picture, samples }| {
                let measured = self.measure(&picture).map(|measured| errors = measured);
                self.write(&picture, samples, rendered.is_ok()).and(measured)
            })
        });
        let kept = self.keep(|keeper, renderer, history| match is_lost {
            true => keeper.write(),
            false => keeper.finish(renderer, history),
        });
        let stats = self.subject.task.files.stats.as_ref();
        let stats = stats.map_or(Ok(()), |path| files::write_json(path, &self.stats(times, errors)));
        rendered.and(written).and(kept).and(stats)
    }

    /// The picture to write: what the device holds, or where it is lost, what was read back last.
    fn last_picture(&mut self, rendered: Result<()>) -> (Result<Option<Copied>>, Result<()>) {
        let read = match &rendered {
            // It would be wrong: a file of an earlier time is left as it is.
            Err(Error::Render(_)) => return (Ok(None), rendered),
            Err(Error::DeviceLost { .. }) => None,
            _ => Some(self.film.renderer.picture()),
        };
        let lost = match (read, rendered) {
            (Some(Ok(picture)), rendered) => {
                return (Ok(Some(Copied { picture, samples: self.film.renderer.samples_done() })), rendered);
            }
            (None, Err(error)) | (Some(Err(error @ Error::DeviceLost { .. })), Ok(())) => error,
            (Some(Err(error)), rendered) => return (Err(error), rendered),
            (None, Ok(())) => return (Ok(None), Ok(())),
        };
        let copied = self.safety_copy.take();
        let clause = match &copied {
            Some(Copied { samples, .. }) => {
                format!("the picture has the {samples} samples per pixel that were last read back from it")
            }
            None => "there is no picture, for none was read back from it yet".to_owned(),
        };
        (Ok(copied), Err(lost.noting(&clause)))
    }

    /// What a fault comes after.
    fn last_good_step(&self) -> String {
        let steps = &self.history.steps;
        match steps.len() {
            0 => "no step was done yet".to_owned(),
            count => {
                let samples: u64 = steps.iter().map(|step| step.spp).sum();
                format!("the last good step is number {count}, which ended at {samples} samples per pixel")
            }
        }
    }

    /// Writes the picture, unless there is nothing on it.
    fn write(&self, picture: &Picture, samples: u32, is_rendered: bool) -> Result<()> {
        let empty = picture.sample_count.iter().filter(|&&count| count == 0).count();
        if empty < picture.sample_count.len() {
            if empty > 0 {
                let all = self.pixels();
                report(
                    "warning",
                    &format!("{empty} of {all} pixels are black: the render ended before their first sample"),
                );
            }
            return self.write_files(picture, samples);
        }
        let message = "the render ended before the first sample, so no picture is written";
        match self.interrupt.is_raised() {
            true => report("warning", message),
            false if is_rendered => return Err(Error::Render(format!("{message}: give it more --time"))),
            false => {}
        }
        Ok(())
    }

    fn stats(&self, times: SetupTimes, errors: Option<metrics::Metrics>) -> Stats {
        let device = self.context.device().clone();
        let spp = self.film.renderer.samples_done().into();
        let sums = Step::new(spp, self.history.paths, self.pixels(), self.history.seconds, &self.history.counts);
        let mut steps = self.history.steps.clone();
        if let Some(last) = steps.last_mut() {
            last.errors = errors;
        }
        Stats {
            scene: self.subject.scene_name.to_owned(),
            settings: self.settings.clone(),
            versions: Versions::of(&device),
            device,
            times,
            totals: Totals {
                sums: Step { errors, ..sums },
                primitives: times.primitive_count,
                nonfinite_samples: self.history.counts.nonfinite,
                noise: self.film.renderer.noise(),
                peak_bytes: self.context.peak_allocated_bytes(),
                peak_resident_bytes: peak_resident_bytes(),
            },
            steps,
        }
    }
}

fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<(T, f64)> {
    let begin = Instant::now();
    Ok((work()?, begin.elapsed().as_secs_f64()))
}

/// Prints every warning once.
fn warn(warnings: &[String]) {
    let mut seen = HashSet::new();
    warnings.iter().filter(|warning| seen.insert(*warning)).for_each(|warning| report("warning", warning));
}

/// Dropped samples make a picture too dark; they come from a scene with infinite or undefined values.
fn warn_of_nonfinite(count: u64) {
    if count > 0 {
        let what = "samples and learning targets were infinite or not a number: such samples count as black";
        report("warning", &format!("{count} {what}"));
    }
}

/// What the validation layer said, if it was on.
fn report_validation(context: &Context) -> Result<()> {
    let messages = context.validation_messages();
    messages.iter().for_each(|message| report("validation", message));
    match messages.len() {
        0 => Ok(()),
        count => Err(Error::Render(format!("the validation layer had {count} complaints"))),
    }
}
