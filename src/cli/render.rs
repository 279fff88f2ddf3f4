//! `lodestar render`: loads, renders step by step, shows progress, and writes what was asked for.

use std::collections::HashSet;
use std::panic::resume_unwind;
use std::process::ExitCode;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use lodestar::bvh::Bvh;
use lodestar::film::Picture;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::image::{Image, metrics};
use lodestar::renderer::{Counts, Renderer, StepReport, Surfaces};
use lodestar::scene::{self, LoadOptions, LoadProgress, Scene};
use lodestar::settings::{Settings, depth_warning};
use lodestar::{Error, Result, files};

use super::interrupt::Interrupt;
use super::outputs::{Outputs, read_reference};
use super::progress::{Loading, Progress, Status};
use super::render_args::RenderArgs;
use super::report;
use super::stats::{SetupTimes, Stats, Step, Totals, Versions, peak_resident_bytes};

/// Samples per pixel where neither the scene, --spp nor --time says.
const DEFAULT_SPP: u32 = 64;

/// Renders as `args` say. Bad input and unwritable outputs are found before any time is spent.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let begin = Instant::now();
    let interrupt = Interrupt::catch()?;
    let loading = Loading::new(args.quiet);
    let options = LoadOptions { defines: args.define.clone() };
    let show = |progress: LoadProgress| loading.show(&progress.to_string());
    let context_options = ContextOptions { device: args.device(), validate: args.validate };
    // Drivers take a while to start.
    let (context, loaded) = thread::scope(|scope| {
        let context = scope.spawn(|| Context::new(&context_options));
        let loaded = timed(|| scene::load_with_progress(&args.scene, &options, &show));
        (context.join(), loaded)
    });
    let (mut scene, load_seconds) = loaded?;
    loading.interleave(|| warn(&scene.warnings));
    let settings = args.settings(&scene)?;
    if args.max_depth.is_none() && args.rr_depth.is_none() {
        loading.interleave(|| warn(depth_warning(&scene).as_slice()));
    }
    let outputs = Outputs::new(args, &scene)?;
    let reference = args.reference.as_deref().map(|path| read_reference(path, &settings)).transpose()?;
    let context = context.unwrap_or_else(|panic| resume_unwind(panic))?;
    loading.show(&format!("building the BVH of {} primitives", scene.primitives.len()));
    let prepare = || rayon::join(|| Bvh::build(&scene.primitives), || Surfaces::new(&scene));
    let ((bvh, surfaces), bvh_seconds) = timed(|| Ok(prepare()))?;
    // From here on the device's copy is the one that is used.
    scene.primitives = Vec::new();
    loading.show("building the kernels");
    let (renderer, pipeline_seconds) = timed(|| Renderer::with_surfaces(&context, &scene, surfaces, &bvh, &settings))?;
    let primitive_count = bvh.primitives.len();
    drop(bvh);
    drop(loading);

    let setup_seconds = begin.elapsed().as_secs_f64();
    let times = SetupTimes { load_seconds, bvh_seconds, pipeline_seconds, setup_seconds, primitive_count };
    let film = Film { renderer, reference, outputs };
    let mut job = Job::new(args, &scene, &context, settings, film, &interrupt);
    let rendered = job.render();
    let finished = job.finish(rendered, times);
    warn_of_nonfinite(job.counts.nonfinite);
    finished.and(report_validation(&context))?;
    Ok(interrupt.exit_code())
}

/// A render under way.
struct Job<'a> {
    args: &'a RenderArgs,
    scene: &'a Scene,
    context: &'a Arc<Context>,
    interrupt: &'a Interrupt,
    settings: Settings,
    film: Film,
    /// Samples per pixel that end the render; a time limit alone means as many as it allows.
    spp_target: Option<u32>,
    /// Whether a step was cut short, by the time limit or a signal.
    is_stopped: bool,
    steps: Vec<Step>,
    counts: Counts,
    paths: u64,
    seconds: f64,
}

/// Where the picture comes from, what it is measured against, and where it goes.
struct Film {
    renderer: Renderer,
    reference: Option<Image>,
    outputs: Outputs,
}

impl<'a> Job<'a> {
    fn new(
        args: &'a RenderArgs,
        scene: &'a Scene,
        context: &'a Arc<Context>,
        settings: Settings,
        film: Film,
        interrupt: &'a Interrupt,
    ) -> Self {
        let default = args.time.is_none().then(|| scene.sample_count.unwrap_or(DEFAULT_SPP));
        Self {
            args,
            scene,
            context,
            interrupt,
            settings,
            film,
            spp_target: args.spp.or(default),
            is_stopped: false,
            steps: Vec::new(),
            counts: Counts::default(),
            paths: 0,
            seconds: 0.0,
        }
    }

    /// Steps until the samples, the time or the user's patience are used up. The clock stands while pictures are written or
    /// measured.
    fn render(&mut self) -> Result<()> {
        let mut progress = Progress::new(self.args.quiet, self.spp_target.map(u64::from), self.args.time);
        let (mut last_write, mut is_writable) = (Instant::now(), true);
        while !self.is_done() {
            let step = self.step()?;
            progress.update(&self.status(&step));
            self.steps.push(step);
            let is_due = self.args.write_every.is_some_and(|every| last_write.elapsed().as_secs_f64() >= every);
            if is_due && !self.is_done() {
                let written = self.film.outputs.write(&self.film.renderer.picture()?, &self.attributes());
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
        let left = self.spp_target.map_or(u32::MAX, |target| target - samples_before);
        let time_left = self.args.time.map(|limit| (limit - self.seconds).max(0.0));
        // A time too long to add up never ends.
        let time_left = time_left.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        let deadline = time_left.and_then(|time_left| Instant::now().checked_add(time_left));
        let stop = || self.interrupt.is_raised() || deadline.is_some_and(|deadline| Instant::now() >= deadline);
        let report = self.film.renderer.step(self.settings.spp_per_step.min(left), &stop)?;

        self.is_stopped = !report.complete;
        self.seconds += report.seconds;
        self.counts.add(&report.counts);
        let spp = self.film.renderer.samples_done() - samples_before;
        let paths = self.paths_of(&report, spp)?;
        self.paths += paths;
        let mut step = Step::new(spp.into(), paths, self.pixels(), report.seconds, &report.counts);
        // At steps 1, 2, 4, 8, ...: the curve is drawn over logarithmic axes.
        if (self.steps.len() + 1).is_power_of_two() {
            step.errors = self.measure(&self.film.renderer.picture()?)?;
        }
        Ok(step)
    }

    /// The paths of a step that has just ended. One that was cut short has sampled some pixels more often than others.
    fn paths_of(&self, report: &StepReport, spp: u32) -> Result<u64> {
        if report.complete {
            return Ok(u64::from(spp) * self.pixels());
        }
        let sample_count = self.film.renderer.picture()?.sample_count;
        Ok(sample_count.into_iter().map(u64::from).sum::<u64>() - self.paths)
    }

    fn is_done(&self) -> bool {
        self.is_stopped
            || self.interrupt.is_raised()
            || self.spp_target.is_some_and(|target| self.film.renderer.samples_done() >= target)
            || self.args.time.is_some_and(|limit| self.seconds >= limit)
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
        let by_samples = self.spp_target.map_or(0.0, |target| f64::from(spp) / f64::from(target));
        let by_time = self.args.time.map_or(0.0, |limit| self.seconds / limit);
        Status {
            spp: spp.into(),
            seconds: self.seconds,
            paths: self.paths,
            light_hit_rate: step.light_hit_rate,
            fraction: by_samples.max(by_time).min(1.0),
        }
    }

    /// Every setting, for the picture's header.
    fn attributes(&self) -> Vec<(String, String)> {
        // By way of text, where 0.95 stays 0.95; as a value it would be widened to 0.949999988079071.
        let settings = serde_json::to_string(&self.settings).and_then(|text| serde_json::from_str(&text));
        let settings: serde_json::Value = settings.unwrap_or_default();
        let settings = settings.as_object().into_iter().flatten();
        let mut attributes: Vec<_> = settings.map(|(name, value)| (name.clone(), plain(value))).collect();
        let device = self.context.device();
        attributes.extend([
            ("version".into(), env!("CARGO_PKG_VERSION").into()),
            ("spp".into(), self.film.renderer.samples_done().to_string()),
            ("seconds".into(), format!("{:.3}", self.seconds)),
            ("device".into(), format!("{} ({})", device.name, device.driver_info)),
            ("scene".into(), self.args.scene.display().to_string()),
        ]);
        attributes
    }

    /// Writes the picture and the statistics, however the render ended, and returns the first failure.
    fn finish(&self, rendered: Result<()>, times: SetupTimes) -> Result<()> {
        let picture = match &rendered {
            // It would be wrong: a file of an earlier time is left as it is.
            Err(Error::Render(_)) => Ok(None),
            _ => self.film.renderer.picture().map(Some),
        };
        let mut errors = None;
        let written = picture.and_then(|picture| {
            picture.map_or(Ok(()), |picture| {
                let measured = self.measure(&picture).map(|measured| errors = measured);
                self.write(&picture, rendered.is_ok()).and(measured)
            })
        });
        let stats = self.args.stats.as_ref().map_or(Ok(()), |path| files::write_json(path, &self.stats(times, errors)));
        rendered.and(written).and(stats)
    }

    /// Writes the picture, unless there is nothing on it.
    fn write(&self, picture: &Picture, is_rendered: bool) -> Result<()> {
        let empty = picture.sample_count.iter().filter(|&&count| count == 0).count();
        if empty < picture.sample_count.len() {
            if empty > 0 {
                let all = self.pixels();
                report(
                    "warning",
                    &format!("{empty} of {all} pixels are black: the render ended before their first sample"),
                );
            }
            return self.film.outputs.write(picture, &self.attributes());
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
        let sums = Step::new(spp, self.paths, self.pixels(), self.seconds, &self.counts);
        let mut steps = self.steps.clone();
        if let Some(last) = steps.last_mut() {
            last.errors = errors;
        }
        Stats {
            scene: self.scene.name.clone(),
            settings: self.settings.clone(),
            versions: Versions::of(&device),
            device,
            times,
            totals: Totals {
                sums: Step { errors, ..sums },
                primitives: times.primitive_count,
                nonfinite_samples: self.counts.nonfinite,
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

/// A setting as text, without the quotes of JSON.
fn plain(value: &serde_json::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// What the validation layer said, if it was on.
/// Dropped samples make a picture too dark; they come from a scene with infinite or undefined values.
fn warn_of_nonfinite(count: u64) {
    if count > 0 {
        report("warning", &format!("{count} samples were infinite or not a number and count as black"));
    }
}

fn report_validation(context: &Context) -> Result<()> {
    let messages = context.validation_messages();
    messages.iter().for_each(|message| report("validation", message));
    match messages.len() {
        0 => Ok(()),
        count => Err(Error::Render(format!("the validation layer had {count} complaints"))),
    }
}
