//! `lodestar render`: loads, renders step by step, shows progress, and writes what was asked for.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lodestar::bvh::Bvh;
use lodestar::files;
use lodestar::film::Picture;
use lodestar::gpu::{Context, ContextOptions};
use lodestar::image::{Image, exr, metrics, png};
use lodestar::renderer::{Counts, Renderer};
use lodestar::scene::{self, LoadOptions, Scene};
use lodestar::settings::Settings;
use lodestar::{Error, Result};

use super::progress::{Progress, Status};
use super::render_args::RenderArgs;
use super::stats::{Stats, Step, Totals, Versions, peak_resident_bytes};

/// Samples per pixel where neither the scene, --spp nor --time says.
const DEFAULT_SPP: u32 = 64;
/// What a shell expects of a program that was interrupted.
const INTERRUPTED: u8 = 130;

/// Renders as `args` say. Bad input and unwritable outputs are found before any time is spent.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let interrupted = on_interrupt()?;
    let (scene, load_seconds) = timed(|| scene::load(&args.scene, &LoadOptions { defines: args.define.clone() }))?;
    warn(&scene.warnings);
    let settings = args.settings(&scene)?;
    let reference = args.reference.as_deref().map(|path| read_reference(path, &settings)).transpose()?;
    let outputs = Outputs::new(args, &scene)?;
    let context = Context::new(&ContextOptions { device: args.device.clone(), validate: args.validate })?;
    let (bvh, bvh_seconds) = timed(|| Ok(Bvh::build(&scene.primitives)))?;
    let (renderer, pipeline_seconds) = timed(|| Renderer::new(&context, &scene, &bvh, &settings))?;

    let mut job = Job::new(args, &scene, settings, renderer, reference, outputs, interrupted);
    let rendered = job.render();
    // Whatever happened, what was rendered is written.
    let times = SetupTimes { load_seconds, bvh_seconds, pipeline_seconds };
    let written = job.finish(&context, &scene, &times);
    rendered.and(written)?;
    report_validation(&context, args.validate)?;
    Ok(if job.interrupted() { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
}

/// A render under way.
struct Job<'a> {
    args: &'a RenderArgs,
    settings: Settings,
    spp_target: Option<u32>,
    renderer: Renderer,
    reference: Option<Image>,
    outputs: Outputs,
    interrupted: Arc<AtomicBool>,
    steps: Vec<Step>,
    counts: Counts,
    seconds: f64,
}

struct SetupTimes {
    load_seconds: f64,
    bvh_seconds: f64,
    pipeline_seconds: f64,
}

impl<'a> Job<'a> {
    fn new(
        args: &'a RenderArgs,
        scene: &Scene,
        settings: Settings,
        renderer: Renderer,
        reference: Option<Image>,
        outputs: Outputs,
        interrupted: Arc<AtomicBool>,
    ) -> Self {
        // A time limit alone means: as many samples as it allows.
        let spp_target = match args.time {
            Some(_) => args.spp,
            None => Some(args.spp.or(scene.sample_count).unwrap_or(DEFAULT_SPP)),
        };
        let (steps, counts) = (Vec::new(), Counts::default());
        Self { args, settings, spp_target, renderer, reference, outputs, interrupted, steps, counts, seconds: 0.0 }
    }

    /// Steps until the samples, the time or the user's patience are used up. The clock stands while pictures are written or
    /// measured.
    fn render(&mut self) -> Result<()> {
        let mut progress = Progress::new(self.args.quiet, self.spp_target.map(u64::from), self.args.time);
        let mut last_write = Instant::now();
        while !self.is_done() {
            let step = self.step()?;
            progress.update(&self.status(&step));
            self.steps.push(step);
            if self.args.write_every.is_some_and(|every| last_write.elapsed().as_secs_f64() >= every) {
                self.outputs.write(&self.renderer.picture()?, &self.attributes())?;
                last_write = Instant::now();
            }
        }
        Ok(())
    }

    fn step(&mut self) -> Result<Step> {
        let left = self.spp_target.map_or(u32::MAX, |target| target - self.renderer.samples_done());
        let samples = self.settings.spp_per_step.min(left);
        let deadline =
            self.args.time.map(|limit| Instant::now() + Duration::from_secs_f64((limit - self.seconds).max(0.0)));
        let interrupted = Arc::clone(&self.interrupted);
        let stop =
            || interrupted.load(Ordering::Relaxed) || deadline.is_some_and(|deadline| Instant::now() >= deadline);
        let report = self.renderer.step(samples, &stop)?;
        self.seconds += report.seconds;
        self.counts.add(&report.counts);
        let mut step = Step::new(&report, self.pixels());
        if self.is_measured(self.steps.len() + 1) || self.is_done() {
            step.errors = self.measure()?;
        }
        Ok(step)
    }

    fn is_done(&self) -> bool {
        self.interrupted()
            || self.spp_target.is_some_and(|target| self.renderer.samples_done() >= target)
            || self.args.time.is_some_and(|limit| self.seconds >= limit)
    }

    fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    fn pixels(&self) -> u64 {
        let window = self.settings.window();
        u64::from(window.width) * u64::from(window.height)
    }

    /// The error is measured at steps 1, 2, 4, 8, ... and at the end.
    fn is_measured(&self, step: usize) -> bool {
        step.is_power_of_two()
    }

    fn measure(&self) -> Result<Option<metrics::Metrics>> {
        let Some(reference) = &self.reference else { return Ok(None) };
        metrics::compare(&self.renderer.picture()?.image(), reference).map(Some)
    }

    fn status(&self, step: &Step) -> Status {
        let spp = self.renderer.samples_done();
        let by_samples = self.spp_target.map_or(0.0, |target| f64::from(spp) / f64::from(target));
        let by_time = self.args.time.map_or(0.0, |limit| self.seconds / limit);
        Status {
            spp: spp.into(),
            seconds: self.seconds,
            paths: u64::from(spp) * self.pixels(),
            light_hit_rate: step.light_hit_rate,
            fraction: by_samples.max(by_time).min(1.0),
        }
    }

    /// Every setting, for the picture's header.
    fn attributes(&self) -> Vec<(String, String)> {
        let settings = serde_json::to_value(&self.settings).unwrap_or_default();
        let settings = settings.as_object().into_iter().flatten();
        let mut attributes: Vec<_> = settings.map(|(name, value)| (name.clone(), plain(value))).collect();
        attributes.extend([
            ("version".into(), env!("CARGO_PKG_VERSION").into()),
            ("spp".into(), self.renderer.samples_done().to_string()),
            ("seconds".into(), format!("{:.3}", self.seconds)),
            ("device".into(), self.outputs.device.clone()),
            ("scene".into(), self.args.scene.display().to_string()),
        ]);
        attributes
    }

    /// Writes the picture and the statistics.
    fn finish(&mut self, context: &Arc<Context>, scene: &Scene, times: &SetupTimes) -> Result<()> {
        self.outputs.device = format!("{} ({})", context.device().name, context.device().driver_info);
        let picture = self.renderer.picture()?;
        let written = self.outputs.write(&picture, &self.attributes());
        if let Some(path) = &self.args.stats {
            files::write_json(path, &self.stats(context, scene, times))?;
        }
        written
    }

    fn stats(&self, context: &Context, scene: &Scene, times: &SetupTimes) -> Stats {
        let device = context.device().clone();
        let mut sums =
            Step::from_counts(self.renderer.samples_done().into(), self.seconds, &self.counts, self.pixels());
        sums.errors = self.steps.last().and_then(|step| step.errors);
        Stats {
            scene: scene.name.clone(),
            settings: self.settings.clone(),
            versions: Versions {
                lodestar: env!("CARGO_PKG_VERSION"),
                vulkan: device.api_version.clone(),
                driver: format!("{} {}", device.driver_name, device.driver_info),
            },
            device,
            load_seconds: times.load_seconds,
            bvh_seconds: times.bvh_seconds,
            pipeline_seconds: times.pipeline_seconds,
            totals: Totals {
                sums,
                primitives: scene.primitives.len(),
                nonfinite_samples: self.counts.nonfinite,
                peak_bytes: context.peak_allocated_bytes(),
                peak_resident_bytes: peak_resident_bytes(),
            },
            steps: self.steps.clone(),
        }
    }
}

/// The files that the picture goes to.
struct Outputs {
    paths: Vec<PathBuf>,
    tone: lodestar::image::ToneCurve,
    exposure: f32,
    device: String,
}

impl Outputs {
    /// Every path is tried before rendering begins.
    fn new(args: &RenderArgs, scene: &Scene) -> Result<Self> {
        let mut paths = args.output.clone();
        if paths.is_empty() {
            paths.push(PathBuf::from(format!("{}.exr", scene.name)));
        }
        paths.iter().chain(&args.stats).try_for_each(|path| files::check_writable(path))?;
        Ok(Self { paths, tone: args.tone, exposure: args.exposure, device: String::new() })
    }

    /// Writes all files; one that fails does not keep the others from being written.
    fn write(&self, picture: &Picture, attributes: &[(String, String)]) -> Result<()> {
        let write = |path: &PathBuf| match path.extension().is_some_and(|extension| extension == "png") {
            true => png::write(path, &picture.image(), self.tone, self.exposure),
            false => exr::write_picture(path, picture, attributes),
        };
        self.paths.iter().map(write).fold(Ok(()), Result::and)
    }
}

/// A flag that the first Ctrl-C sets; the second ends the process at once.
fn on_interrupt() -> Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        // In this order: a signal finds the flag set only if another came before.
        signal_hook::flag::register_conditional_shutdown(signal, INTERRUPTED.into(), Arc::clone(&flag))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&flag)))
            .map_err(|error| Error::Render(format!("signals cannot be caught: {error}")))?;
    }
    Ok(flag)
}

fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<(T, f64)> {
    let begin = Instant::now();
    Ok((work()?, begin.elapsed().as_secs_f64()))
}

fn warn(warnings: &[String]) {
    for warning in warnings {
        eprintln!("lodestar: warning: {warning}");
    }
}

/// The reference, cut to the rendered window where it is as large as the whole film.
fn read_reference(path: &Path, settings: &Settings) -> Result<Image> {
    let image = exr::read_rgb(path)?;
    let window = settings.window();
    let size = (image.width, image.height);
    if size == (window.width, window.height) {
        return Ok(image);
    }
    let whole = size == (settings.width, settings.height);
    let cut = whole.then(|| image.crop([window.x, window.y], window.width, window.height)).flatten();
    cut.ok_or_else(|| {
        Error::image(
            path,
            format!(
                "the reference has {} x {} pixels, but {} x {} are rendered: choose that size with --width and --height",
                size.0, size.1, window.width, window.height
            ),
        )
    })
}

/// A setting as text, without the quotes of JSON.
fn plain(value: &serde_json::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn report_validation(context: &Context, validate: bool) -> Result<()> {
    let messages = context.validation_messages();
    if !validate || messages.is_empty() {
        return Ok(());
    }
    messages.iter().for_each(|message| eprintln!("lodestar: validation: {message}"));
    Err(Error::Render(format!("the validation layer had {} complaints", messages.len())))
}
