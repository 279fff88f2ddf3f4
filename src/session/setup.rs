//! Setup of a session: from a scene file or a checkpoint to the first step. Bad input and files that cannot be written are found
//! before the render begins.

use std::borrow::Cow;
use std::collections::HashSet;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use crate::denoise::Denoiser;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::surfaces::Surfaces;
use crate::film::ranges::SampleRanges;
use crate::fleet::Fleet;
use crate::gpu::Context;
use crate::image::Image;
use crate::renderer::Renderer;
use crate::scene::{self, LoadOptions, Scene};
use crate::session::checkpoint::Record;
use crate::session::checkpoints::CheckpointFile;
use crate::session::files::{OutputFiles, PictureFiles, read_reference};
use crate::session::guide_file::GuideFile;
use crate::session::history::History;
use crate::session::identity::Identity;
use crate::session::kernel_files::KernelFiles;
use crate::session::length::Length;
use crate::session::options::{DeviceChoice, Options};
use crate::session::prepared::{Earlier, Prepared};
use crate::session::profiler::Profiler;
use crate::session::progress::{Event, Preparation, Watch};
use crate::session::ranks;
use crate::session::run::{Origin, Output, Session, Subject, device_name};
use crate::session::safety_copy::SafetyCopy;
use crate::session::saved::SavedCheckpoint;
use crate::session::start::{Resumed, SceneInput, Start};
use crate::session::statistics::SetupTimes;
use crate::settings::{Execution, Settings};
use crate::{Error, Result};

/// Settings and length of a render whose scene is known, and the part of it that a checkpoint holds.
struct Plan {
    settings: Settings,
    length: Length,
    earlier: Option<Earlier>,
}

/// Files and kernels of a render. They are read and tried before the render begins.
struct Inputs {
    wanted: OutputFiles,
    pictures: PictureFiles,
    kernels: KernelFiles,
    /// The picture that errors are measured against.
    reference: Option<Image>,
}

impl Session {
    /// Makes everything ready for the first step of a new render of `scene`.
    ///
    /// # Errors
    /// Where an option does not suit the scene, no device can be used, or the device cannot hold the scene.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self> {
        Self::start(Start::Anew(SceneInput::Memory(scene)), options, &Watch::silent())
    }

    /// Reads a Mitsuba scene and makes everything ready for the first step.
    ///
    /// # Errors
    /// Where [`Session::new`] fails, and where the scene cannot be read.
    pub fn open(scene: impl AsRef<Path>, options: &Options) -> Result<Self> {
        let input = SceneInput::File { path: scene.as_ref().to_path_buf(), options: LoadOptions::default() };
        Self::start(Start::Anew(input), options, &Watch::silent())
    }

    /// Goes on with a render from its checkpoint. The settings are those of the checkpoint. A length in `options` replaces the
    /// length of the checkpoint; its seconds count from now.
    ///
    /// # Errors
    /// Where the checkpoint cannot be read, or its scene has changed.
    pub fn resume(checkpoint: impl AsRef<Path>, options: &Options) -> Result<Self> {
        let start = Start::Resume { checkpoint: checkpoint.as_ref().to_path_buf(), moved_scene: None };
        Self::start(start, options, &Watch::silent())
    }

    /// Makes everything ready for the first step and tells `watch` every event.
    ///
    /// # Errors
    /// Where [`Session::open`] or [`Session::resume`] fails.
    pub fn start(start: Start<'_>, options: &Options, watch: &Watch<'_>) -> Result<Self> {
        let prepared = Self::prepare(start, options, watch);
        let prepared = match &options.exchange {
            Some(exchange) => ranks::join(exchange, prepared)?,
            None => prepared?,
        };
        prepared.begin(watch)
    }

    /// Does what needs no other rank.
    fn prepare(start: Start<'_>, options: &Options, watch: &Watch<'_>) -> Result<Prepared> {
        let guide = GuideFile::of(&start, options)?;
        // Files that cannot be written are found before a large scene is read.
        let checkpoint = start.kept_file(options, watch)?;
        let (input, resumed) = start.read(checkpoint.as_ref())?;
        let input = input.in_folder(watch)?;
        options.files.as_ref().map_or(Ok(()), OutputFiles::check_writable)?;
        let denoise = options.files.as_ref().and_then(|files| files.denoise.as_ref());
        let denoiser = denoise.map(Denoiser::open).transpose()?;
        let begin = Instant::now();
        let (opened, loaded) = open_and_load(&input, options, watch);
        let (scene, load_seconds) = loaded?;
        warn_once(&scene.warnings, watch);
        let scene_hash = scene::fingerprint(&scene)?;
        guide.iter().try_for_each(|guide| guide.check_scene(&scene_hash))?;
        let plan = Plan::new(&scene, &scene_hash, resumed, guide.as_ref(), options, watch)?;
        // A render that goes on has its guide already.
        let guide = guide.filter(|_| plan.earlier.is_none());
        let scene_path = input.absolute_path().unwrap_or_else(|| PathBuf::from(&scene.name));
        let inputs = Inputs::new(&plan, &scene, options, watch)?;
        if !inputs.wanted.overwrite {
            inputs.pictures.check_scene(&scene_path, &scene_hash)?;
        }
        let contexts = opened.unwrap_or_else(|panic| resume_unwind(panic))?;
        let context = Arc::clone(&contexts[0]);

        let (scene_name, primitive_count) = (scene.name.clone(), scene.primitives.len());
        let (fleet, guide_cells, bvh_seconds, pipeline_seconds) =
            build(scene, &contexts, &plan.settings, &inputs.kernels, guide.as_ref(), watch)?;
        watch.tell(Event::Ready);
        inputs.kernels.unused(fleet.first().back_end()).iter().for_each(|warning| watch.warn(warning));
        let setup_seconds = begin.elapsed().as_secs_f64();
        let times = SetupTimes { load_seconds, bvh_seconds, pipeline_seconds, setup_seconds, primitive_count };
        let kernels = inputs.kernels.used(fleet.first().back_end());
        let source = input.source();
        let subject = Subject { scene_name, scene_path, scene_hash, source, kernels, times };

        let Plan { settings, length, earlier } = plan;
        let Inputs { wanted, pictures, reference, .. } = inputs;
        let session = Self {
            length,
            subject,
            reference,
            output: output(&wanted, pictures, denoiser, checkpoint.as_ref()),
            profiler: wanted.profile.map(|path| Profiler::start(path, &context)),
            profile: None,
            rescued: None,
            checkpoints: None,
            history: History::default(),
            origin: Origin::default(),
            context,
            fleet,
            settings,
        };
        let devices = contexts.iter().map(|context| device_name(context)).collect();
        let guide = guide.zip(guide_cells);
        Ok(Prepared { session, devices, earlier, guide, checkpoint, deals_by_speed: options.deals_by_speed })
    }
}

impl DeviceChoice {
    /// Opens the devices: at least one. Ranks on one machine take its devices in turn.
    fn open(&self, local_rank: Option<usize>) -> Result<Vec<Arc<Context>>> {
        match self {
            Self::Open(options) => match local_rank {
                Some(local_rank) if options.device.is_none() => Ok(vec![Context::of_local_rank(options, local_rank)?]),
                _ => Context::all(options),
            },
            Self::Opened(context) => Ok(vec![Arc::clone(context)]),
        }
    }
}

impl Plan {
    fn new(
        scene: &Scene,
        scene_hash: &str,
        resumed: Option<Resumed>,
        guide: Option<&GuideFile>,
        options: &Options,
        watch: &Watch<'_>,
    ) -> Result<Self> {
        let mut plan = match resumed {
            None => Self::anew(scene, options)?,
            Some(resumed) if resumed.is_asked => Self::resumed(resumed, options, scene_hash)?,
            Some(found) => Self::anew(scene, options)?.going_on(found, scene_hash, guide, watch)?,
        };
        plan.complete(options)?;
        if plan.earlier.is_none() {
            options.depth_warning(scene).iter().for_each(|warning| watch.warn(warning));
        }
        Ok(plan)
    }

    fn anew(scene: &Scene, options: &Options) -> Result<Self> {
        let settings = options.settings_for(scene)?;
        let length = options.length_for(scene, &settings);
        Ok(Self { settings, length, earlier: None })
    }

    /// This new render, which goes on from the checkpoint that it has found in its file. It must be the checkpoint of this render.
    fn going_on(self, found: Resumed, scene_hash: &str, guide: Option<&GuideFile>, watch: &Watch<'_>) -> Result<Self> {
        let Self { mut settings, length, .. } = self;
        let Resumed { file, checkpoint: SavedCheckpoint { scene, settings: theirs, device, record, state }, .. } =
            found;
        // Where a driver ends loops early, a render goes on with a half, a quarter, ... of the samples per dispatch.
        let halves = std::iter::successors(Some(settings.samples_per_dispatch), |samples| Some(samples / 2));
        if halves.take_while(|&samples| samples > 0).any(|samples| samples == theirs.samples_per_dispatch) {
            settings.samples_per_dispatch = theirs.samples_per_dispatch;
        }
        let (there, here) = (Identity::of_render(&scene.hash, &theirs), Identity::of_render(scene_hash, &settings));
        let named = |ranges: &SampleRanges| if ranges.first().is_some() { ranges.to_string() } else { "none".into() };
        let guide_samples = guide.map(GuideFile::samples).unwrap_or_default();
        let of_guide = (guide_samples != record.guide_samples).then(|| {
            let [there, here] = [&record.guide_samples, &guide_samples].map(named);
            format!("samples of the guide that it began with ({there} there, {here} here)")
        });
        let differences: Vec<_> = there.difference(&here).into_iter().chain(of_guide).collect();
        let done = state.samples_done;
        if !differences.is_empty() {
            let differences = differences.join(", ");
            let message =
                format!("it is the checkpoint of another render: {differences}; give another name or remove it");
            return Err(Error::checkpoint(file, message));
        }
        if length.spp.is_some_and(|spp| spp < done) {
            let message = format!(
                "it holds {done} samples per pixel of this render already, and --spp asks for less; give another name or \
                 remove it"
            );
            return Err(Error::checkpoint(file, message));
        }
        let file = file.display();
        watch.tell(Event::Note(&format!(
            "{file} holds {done} samples per pixel of this render; it goes on with them (remove the file to begin anew)"
        )));
        // The caller names the pictures.
        let record = Record { outputs: PictureFiles::none(), ..record };
        Ok(Self { settings, length, earlier: Some(Earlier { record, device, state }) })
    }

    fn resumed(resumed: Resumed, options: &Options, scene_hash: &str) -> Result<Self> {
        let Resumed { file, checkpoint: SavedCheckpoint { scene, settings, device, record, state }, .. } = resumed;
        if scene.hash != scene_hash {
            let message = format!(
                "the scene has changed since the render began: scene_hash ({} there, {scene_hash} here); undo the changes \
                 to {} and to the files that it reads",
                scene.hash, scene.path
            );
            return Err(Error::checkpoint(file, message));
        }
        let length = match options.length {
            asked if asked.is_given() => {
                let seconds = asked.seconds.map(|seconds| record.history.seconds + seconds);
                Length { spp: asked.spp, seconds }
            }
            _ => record.length,
        };
        if length.spp.is_some_and(|spp| spp < state.samples_done) {
            let message = format!("it holds {} samples per pixel already; ask for more with --spp", state.samples_done);
            return Err(Error::checkpoint(file, message));
        }
        if options.leads() && options.files.as_ref().is_none_or(|files| files.pictures.is_empty()) {
            record.outputs.check_place(&file)?;
        }
        Ok(Self { settings, length, earlier: Some(Earlier { record, device, state }) })
    }

    /// Sets the settings that do not decide what the picture is, and checks all settings.
    fn complete(&mut self, options: &Options) -> Result<()> {
        options.set_execution(&mut self.settings);
        self.settings.validate()?;
        self.length.check_sample_range(&self.settings)?;
        if options.kernel_folder.is_some() && self.settings.execution == Execution::Auto {
            // An edited megakernel must run, also where wavefront kernels would be faster.
            self.settings.execution = Execution::Megakernel;
        }
        Ok(())
    }
}

impl Inputs {
    fn new(plan: &Plan, scene: &Scene, options: &Options, watch: &Watch<'_>) -> Result<Self> {
        let earlier = plan.earlier.as_ref().map(|earlier| &earlier.record.outputs);
        let pictures = match &options.files {
            Some(wanted) => PictureFiles::new(wanted, earlier, &scene.name)?,
            None => earlier.cloned().unwrap_or_else(PictureFiles::none),
        };
        let kernels = KernelFiles::load(options.kernel_folder.as_deref())?;
        kernels.warnings().iter().for_each(|warning| watch.warn(warning));
        let wanted = options.files.clone().unwrap_or_default();
        let reference = wanted.reference.as_deref().map(|path| read_reference(path, &plan.settings)).transpose()?;
        Ok(Self { wanted, pictures, kernels, reference })
    }
}

/// Result of the thread that opens the devices. The outer error is the thread's panic.
type OpenedDevices = thread::Result<Result<Vec<Arc<Context>>>>;

/// Opens the devices while the scene is read, because drivers take a while to start.
fn open_and_load<'a>(
    input: &SceneInput<'a>,
    options: &Options,
    watch: &Watch<'_>,
) -> (OpenedDevices, Result<(Cow<'a, Scene>, f64)>) {
    thread::scope(|scope| {
        let local_rank = options.exchange.as_ref().map(|exchange| exchange.local_rank());
        let context = scope.spawn(move || options.device.open(local_rank));
        let loaded = timed(|| input.load(watch));
        (context.join(), loaded)
    })
}

/// The renderers of a scene, the cells of the guide that begins the render, and the seconds that hierarchy and kernels took.
fn build(
    mut scene: Cow<'_, Scene>,
    contexts: &[Arc<Context>],
    settings: &Settings,
    kernels: &KernelFiles,
    guide: Option<&GuideFile>,
    watch: &Watch<'_>,
) -> Result<(Fleet, Option<Cells>, f64, f64)> {
    watch.tell(Event::Preparing(Preparation::Hierarchy(scene.primitives.len())));
    let prepare = || rayon::join(|| Bvh::build(&scene.primitives), || Surfaces::new(&scene));
    let ((bvh, surfaces), bvh_seconds) = timed(|| Ok(prepare()))?;
    if let Cow::Owned(scene) = &mut scene {
        // The hierarchy and the surfaces have all that the renderer needs of the primitives.
        drop(std::mem::take(&mut scene.primitives));
    }
    watch.tell(Event::Preparing(Preparation::Kernels));
    let build = || {
        let build =
            |context, surfaces| Renderer::with_surfaces(context, &scene, surfaces, &bvh, settings, kernels.registry());
        let others =
            contexts[1..].iter().map(|context| build(context, surfaces.clone())).collect::<Result<Vec<_>>>()?;
        Fleet::new(build(&contexts[0], surfaces)?, others)
    };
    let (fleet, pipeline_seconds) = timed(build)?;
    let guide_cells = guide.map(|guide| guide.cells(&fleet, &bvh));
    Ok((fleet, guide_cells, bvh_seconds, pipeline_seconds))
}

fn output(
    wanted: &OutputFiles,
    pictures: PictureFiles,
    denoiser: Option<Denoiser>,
    checkpoint: Option<&CheckpointFile>,
) -> Output {
    let intervals = wanted.write_interval().into_iter().chain(checkpoint.map(|file| file.every));
    Output {
        pictures,
        write_every: wanted.write_every,
        statistics: wanted.statistics.clone(),
        denoiser,
        safety_copy: SafetyCopy::new(intervals.collect::<Vec<Duration>>()),
        last_write: Instant::now(),
        is_writable: true,
    }
}

fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<(T, f64)> {
    let begin = Instant::now();
    Ok((work()?, begin.elapsed().as_secs_f64()))
}

/// Tells `watch` every warning once.
fn warn_once(warnings: &[String], watch: &Watch<'_>) {
    let mut seen = HashSet::new();
    warnings.iter().filter(|warning| seen.insert(*warning)).for_each(|warning| watch.warn(warning));
}
