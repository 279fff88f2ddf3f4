//! What is to be rendered and where it goes, whether it begins or is gone on with.

use std::path::{Path, PathBuf};
use std::time::Duration;

use lodestar::renderer::{Counts, RenderState};
use lodestar::scene::Scene;
use lodestar::session::checkpoint::Checkpoint;
use lodestar::session::identity::Identity;
use lodestar::settings::{Settings, depth_warning};
use lodestar::{Error, Result, files};
use serde::{Deserialize, Serialize};

use super::outputs::Outputs;
use super::render_args::{DeviceArgs, OutputArgs, RenderArgs};
use super::stats::Step;

/// Samples per pixel where neither the scene, --spp, --time nor --noise says.
const DEFAULT_SPP: u32 = 64;

/// A render as the command line asks for it.
pub struct Task {
    pub scene: PathBuf,
    pub define: Vec<(String, String)>,
    pub files: OutputArgs,
    pub device: DeviceArgs,
    pub checkpoint: Option<CheckpointFile>,
}

/// Where checkpoints go, and how often.
#[derive(Debug, Clone)]
pub struct CheckpointFile {
    pub path: PathBuf,
    pub every: Duration,
}

impl CheckpointFile {
    /// The file, every so many seconds.
    pub fn new(path: PathBuf, seconds: f64) -> Self {
        // A time too long to count in never comes.
        Self { path, every: Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX) }
    }

    /// Fails where the file cannot be written, or where a new render would take an older one's place.
    pub fn check(&self, is_resumed: bool, identity: &Identity) -> Result<()> {
        files::check_writable(&self.path)?;
        if is_resumed || !self.path.exists() {
            return Ok(());
        }
        let file = self.path.display();
        let Checkpoint { scene, settings, state, .. } = Checkpoint::<JobRecord>::read(&self.path).map_err(|error| {
            Error::checkpoint(
                &self.path,
                format!("the file is there already and no checkpoint to go on with; give another name ({error})"),
            )
        })?;
        let message = match Identity::of_render(&scene.hash, &settings).difference(identity) {
            Some(difference) => {
                format!("it is the checkpoint of another render: {difference}; give another name or remove it")
            }
            None => format!(
                "it holds {} samples per pixel of this render already: `lodestar resume {file}` goes on with them; remove it to begin anew",
                state.samples_done
            ),
        };
        Err(Error::checkpoint(&self.path, message))
    }
}

/// Where a render starts from.
pub enum Start<'a> {
    /// From nothing.
    New(&'a RenderArgs),
    /// From a checkpoint and the file that it was in.
    Resumed(&'a Path, Box<Checkpoint<JobRecord>>),
}

/// What ends a render, whichever is reached first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Length {
    /// Samples per pixel.
    pub spp: Option<u32>,
    /// Seconds of rendering, those before a checkpoint included.
    pub seconds: Option<f64>,
}

/// What has been done so far.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct History {
    pub seconds: f64,
    pub paths: u64,
    pub counts: Counts,
    pub steps: Vec<Step>,
}

/// What a checkpoint remembers for the command line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobRecord {
    pub length: Length,
    pub outputs: Outputs,
    /// The files that stand in for built-in kernels, with their hashes.
    pub kernels: Vec<String>,
    pub history: History,
}

/// How a render begins, once its scene is known.
pub struct Beginning {
    pub settings: Settings,
    pub length: Length,
    pub before: Option<Before>,
    /// What is not as the user may expect.
    pub warning: Option<String>,
}

/// What a checkpoint held.
pub struct Before {
    pub history: History,
    pub outputs: Outputs,
    pub device: String,
    pub kernels: Vec<String>,
    pub state: RenderState,
}

impl Start<'_> {
    /// Settings and length of the render of `scene`.
    ///
    /// # Errors
    /// Where an option is out of its range, or the checkpoint is another scene's.
    pub fn begin(self, scene: &Scene, scene_hash: &str, device: &DeviceArgs) -> Result<Beginning> {
        let mut beginning = match self {
            Self::New(args) => begin_new(args, scene)?,
            Self::Resumed(path, checkpoint) => begin_resumed(path, *checkpoint, scene_hash)?,
        };
        beginning.settings.slice_milliseconds = device.slice_ms;
        beginning.settings.execution = device.execution;
        beginning.settings.validate()?;
        check_sample_range(&beginning)?;
        Ok(beginning)
    }
}

fn begin_new(args: &RenderArgs, scene: &Scene) -> Result<Beginning> {
    let is_depth_chosen = args.choices.max_depth.is_some() || args.choices.rr_depth.is_some();
    let ends_otherwise = args.length.time.is_some() || args.choices.noise.is_some();
    let default = (!ends_otherwise).then(|| scene.sample_count.unwrap_or(DEFAULT_SPP));
    Ok(Beginning {
        settings: args.choices.settings(scene)?,
        length: Length { spp: args.length.spp.or(default), seconds: args.length.time },
        before: None,
        warning: depth_warning(scene).filter(|_| !is_depth_chosen),
    })
}

fn begin_resumed(path: &Path, checkpoint: Checkpoint<JobRecord>, scene_hash: &str) -> Result<Beginning> {
    let Checkpoint { scene, settings, device, job: JobRecord { length, outputs, kernels, history }, state } =
        checkpoint;
    if scene.hash != scene_hash {
        let message = format!(
            "the scene is not the one it was begun with: scene_hash ({} there, {scene_hash} here); undo what has changed \
             in {} and what that reads",
            scene.hash, scene.path
        );
        return Err(Error::checkpoint(path, message));
    }
    if length.spp.is_some_and(|spp| spp < state.samples_done) {
        let message = format!("it holds {} samples per pixel already; ask for more with --spp", state.samples_done);
        return Err(Error::checkpoint(path, message));
    }
    Ok(Beginning { settings, length, before: Some(Before { history, outputs, device, kernels, state }), warning: None })
}

/// Samples are numbered in 32 bits.
fn check_sample_range(beginning: &Beginning) -> Result<()> {
    let offset = beginning.settings.sample_offset.unwrap_or(0);
    match offset.checked_add(beginning.length.spp.unwrap_or(0)) {
        Some(_) => Ok(()),
        None => Err(Error::Settings(format!("--sample-offset {offset} and --spp add up to more than 2^32 samples"))),
    }
}
