//! A render before its first step: scene, devices and kernels are ready, and what it begins with is known.

use std::borrow::Cow;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use crate::Result;
use crate::denoise::Denoiser;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::surfaces::Surfaces;
use crate::fleet::Fleet;
use crate::fleet::team::Team;
use crate::gpu::Context;
use crate::renderer::Renderer;
use crate::renderer::guide_state::check_learns_radiance;
use crate::scene::fingerprint::{Fingerprints, fingerprints};
use crate::scene::{KeptMeshes, Scene};
use crate::session::checkpoints::CheckpointFile;
use crate::session::devices::device_name;
use crate::session::files::OutputFiles;
use crate::session::guide_file::GuideFile;
use crate::session::length::Length;
use crate::session::options::Options;
use crate::session::output::Output;
use crate::session::plan::{Earlier, Inputs, Plan};
use crate::session::profiler::Profiler;
use crate::session::progress::{Event, Preparation, Watch};
use crate::session::running::Running;
use crate::session::start::{SceneInput, Start};
use crate::session::statistics::{SetupTimes, timed};
use crate::session::subject::Subject;
use crate::settings::Settings;

/// A render that has not begun.
pub(super) struct Prepared {
    context: Arc<Context>,
    fleet: Fleet,
    settings: Settings,
    length: Length,
    subject: Subject,
    output: Output,
    profiler: Option<Profiler>,
    /// Names of the devices with their drivers, of all ranks once these are known.
    devices: Vec<String>,
    earlier: Option<Earlier>,
    /// Guide that begins the render, with its cells.
    guide: Option<(GuideFile, Cells)>,
    checkpoint: Option<CheckpointFile>,
    /// Whether tiles are dealt out to devices by their measured speed.
    deals_by_speed: bool,
}

impl Prepared {
    /// Does everything that needs no other rank: files are tried, the scene is read, the devices are opened and the kernels built.
    ///
    /// # Errors
    /// Where a file cannot be read or written, an option does not suit the scene, or no device can hold it.
    pub fn new(start: Start<'_>, options: &Options, watch: &Watch<'_>) -> Result<Self> {
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
        watch.warn_once(&scene.warnings);
        let Fingerprints { scene: scene_hash, world: world_hash, geometry } = fingerprints(&scene)?;
        guide.iter().try_for_each(|guide| guide.check_scene(&world_hash))?;
        let plan = Plan::new(&scene, &scene_hash, resumed, guide.as_ref(), options, watch)?;
        if options.files.as_ref().is_some_and(|files| files.guide.is_some()) {
            check_learns_radiance(&plan.settings)?;
        }
        // A render that goes on has its guide already.
        let guide = guide.filter(|_| plan.earlier.is_none());
        let scene_path = input.absolute_path().unwrap_or_else(|| PathBuf::from(&scene.name));
        let inputs = Inputs::new(&plan, &scene, options, watch)?;
        inputs.pictures.check_size(&plan.settings.window())?;
        if !inputs.wanted.overwrite {
            inputs.pictures.check_scene(&scene_path, &scene_hash)?;
        }
        let contexts = opened.unwrap_or_else(|panic| resume_unwind(panic))?;
        let context = Arc::clone(&contexts[0]);

        let (scene_name, primitive_count) = (scene.name.clone(), scene.stored_primitives());
        let (fleet, guide_cells, bvh_seconds, pipeline_seconds) =
            build(scene, &contexts, &plan.settings, &inputs, guide.as_ref(), watch)?;
        watch.tell(Event::Ready);
        inputs.kernels.unused(fleet.first().back_end()).iter().for_each(|warning| watch.warn(warning));
        let setup_seconds = begin.elapsed().as_secs_f64();
        let times = SetupTimes { load_seconds, bvh_seconds, pipeline_seconds, setup_seconds, primitive_count };
        let kernels = inputs.kernels.used(fleet.first().back_end());
        let source = input.source();

        let Plan { settings, length, earlier } = plan;
        let Inputs { wanted, pictures, reference, kernels: kernel_files } = inputs;
        let checkpoint_every = checkpoint.as_ref().map(|file| file.every);
        Ok(Self {
            output: Output::new(&wanted, pictures, reference, denoiser, checkpoint_every),
            profiler: wanted.profile.map(|path| Profiler::start(path, &context)),
            subject: Subject {
                scene_name,
                scene_path,
                scene_hash,
                world_hash,
                geometry,
                bvh: None,
                meshes: KeptMeshes::default(),
                source,
                kernels,
                kernel_files,
                options: options.for_other_scenes(),
                times,
                is_changed: false,
            },
            devices: contexts.iter().map(|context| device_name(context)).collect(),
            guide: guide.zip(guide_cells),
            deals_by_speed: options.deals_by_speed,
            context,
            fleet,
            settings,
            length,
            earlier,
            checkpoint,
        })
    }

    /// Names of this rank's devices with their drivers.
    pub fn devices(&self) -> &[String] {
        &self.devices
    }

    /// Facts in which all ranks must agree.
    pub fn facts(&self) -> Vec<(String, String)> {
        self.subject.facts(&self.settings)
    }

    /// This render as a part of a team's.
    pub fn join(mut self, team: &Arc<Team>) -> Result<Self> {
        self.fleet.join(team)?;
        self.devices = team.members().iter().flat_map(|member| member.devices.clone()).collect();
        Ok(self)
    }

    /// Does what the first rank names until the render ends.
    pub fn serve(mut self) -> Result<()> {
        self.fleet.serve()
    }

    /// Begins the render, with the state and the guide that it begins with.
    pub fn begin(self, watch: &Watch<'_>) -> Result<Running> {
        let Self { context, mut fleet, settings, length, subject, output, profiler, devices, .. } = self;
        warn_of_mix(&devices, watch);
        if self.deals_by_speed && devices.len() > 1 {
            let weights = fleet.deal_by_speed()?;
            watch.tell(Event::Note(&dealt(&devices, &weights)));
        }
        let world_hash = subject.world_hash.clone();
        let mut running = Running::new(context, fleet, settings, length, subject, output, profiler);
        let samples_written = self.earlier.map(|earlier| running.go_on_from(earlier, watch)).transpose()?;
        if let Some((guide, cells)) = self.guide {
            guide.begin(cells, &world_hash, &mut running, watch)?;
        }
        if let Some(file) = self.checkpoint {
            running.keep_checkpoints(file, samples_written)?;
        }
        running.tell_beginning(watch);
        Ok(running)
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
        let loaded = timed(|| input.load(None, watch));
        (context.join(), loaded)
    })
}

/// The renderers of a scene, the cells of the guide that begins the render, and the seconds that hierarchy and kernels took.
fn build(
    mut scene: Cow<'_, Scene>,
    contexts: &[Arc<Context>],
    settings: &Settings,
    inputs: &Inputs,
    guide: Option<&GuideFile>,
    watch: &Watch<'_>,
) -> Result<(Fleet, Option<Cells>, f64, f64)> {
    watch.tell(Event::Preparing(Preparation::Hierarchy(scene.stored_primitives())));
    let prepare = || rayon::join(|| Bvh::of_scene(&scene), || Surfaces::new(&scene));
    let ((bvh, surfaces), bvh_seconds) = timed(|| Ok(prepare()))?;
    if let Cow::Owned(scene) = &mut scene {
        // The hierarchy and the surfaces have all that the renderer needs of the primitives.
        drop((std::mem::take(&mut scene.primitives), std::mem::take(&mut scene.groups)));
        drop((std::mem::take(&mut scene.instances), std::mem::take(&mut scene.deformations)));
    }
    watch.tell(Event::Preparing(Preparation::Kernels));
    let (registry, work) = (inputs.kernels.registry(), inputs.picture_work());
    let build = || {
        let build = |context, surfaces| Renderer::with_work(context, &scene, surfaces, &bvh, settings, registry, work);
        let others =
            contexts[1..].iter().map(|context| build(context, surfaces.clone())).collect::<Result<Vec<_>>>()?;
        Fleet::new(build(&contexts[0], surfaces)?, others)
    };
    let (fleet, pipeline_seconds) = timed(build)?;
    let guide_cells = guide.map(|guide| guide.cells(&fleet, &bvh));
    Ok((fleet, guide_cells, bvh_seconds, pipeline_seconds))
}

/// How tiles were dealt out, in one sentence.
fn dealt(devices: &[String], weights: &[u32]) -> String {
    let all: u32 = weights.iter().sum();
    let of_device = |(device, weight): (&String, &u32)| format!("{weight} of {all} to {device}");
    format!("tiles by measured speed: {}", devices.iter().zip(weights).map(of_device).collect::<Vec<_>>().join(", "))
}

/// Warns where devices of several kinds render one picture.
fn warn_of_mix(devices: &[String], watch: &Watch<'_>) {
    if devices.iter().any(|device| *device != devices[0]) {
        watch.warn(
            "devices of different kinds render this picture: it is unbiased, but its last bits depend on the devices and \
             their order",
        );
    }
}
