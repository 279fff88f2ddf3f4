//! Starts of a session: a new render of a scene, or one that goes on from its checkpoint.

use std::borrow::Cow;
use std::path::PathBuf;

use crate::scene::{self, KeptMeshes, LoadOptions, Scene};
use crate::session::checkpoints::CheckpointFile;
use crate::session::options::Options;
use crate::session::progress::{Event, Preparation, Watch};
use crate::session::saved::SavedCheckpoint;
use crate::{Error, Result, inputs};

/// The beginning of a render.
#[derive(Debug, Clone)]
pub enum Start<'a> {
    /// A new render.
    Anew(SceneInput<'a>),
    /// A render that goes on from its checkpoint, to the same bits as if it had never stopped.
    Resume {
        /// File of the checkpoint.
        checkpoint: PathBuf,
        /// New path of the scene's file, if the file was moved.
        moved_scene: Option<PathBuf>,
    },
}

/// A scene to render.
#[derive(Debug, Clone)]
pub enum SceneInput<'a> {
    /// A file.
    File {
        /// Path of the file.
        path: PathBuf,
        /// Choices with which it is read.
        options: LoadOptions,
    },
    /// A scene in memory. Its render cannot keep a checkpoint.
    Memory(&'a Scene),
    /// A scene in memory that [`Scene::load`] has read from a file.
    Read {
        /// The scene.
        scene: &'a Scene,
        /// Path of its file.
        path: PathBuf,
        /// Choices with which it is read.
        options: LoadOptions,
    },
}

/// A checkpoint to go on from.
pub(super) struct Resumed {
    pub file: PathBuf,
    pub checkpoint: SavedCheckpoint,
    /// Whether the caller has asked to go on. Otherwise the checkpoint was found where a new render keeps its own.
    pub is_asked: bool,
}

impl<'a> Start<'a> {
    /// File of the checkpoint that the render keeps, if it keeps one. A resumed render keeps the file that it came from.
    pub(super) fn kept_file(&self, options: &Options, watch: &Watch<'_>) -> Result<Option<CheckpointFile>> {
        let path = match self {
            Self::Anew(_) => options.checkpoint.as_ref(),
            Self::Resume { checkpoint, .. } => Some(checkpoint),
        };
        let Some(path) = path.filter(|_| options.leads()) else { return Ok(None) };
        if matches!(self, Self::Resume { .. }) {
            // A file that is missing is not one that cannot be written.
            inputs::open(path)?;
        }
        CheckpointFile::take(path, options.checkpoint_every, watch).map(Some)
    }

    /// The scene to read, and the checkpoint of a render that goes on. `kept` is the file of the checkpoint that the render keeps.
    pub(super) fn read(self, kept: Option<&CheckpointFile>) -> Result<(SceneInput<'a>, Option<Resumed>)> {
        match self {
            Self::Anew(input) => {
                let file = kept.map(|kept| kept.path.clone()).filter(|file| file.exists());
                Ok((input, file.map(Resumed::found).transpose()?))
            }
            Self::Resume { checkpoint: file, moved_scene } => {
                let checkpoint = SavedCheckpoint::open(&file)?;
                let path = moved_scene.map_or_else(|| scene_of(&checkpoint), Ok)?;
                let input = SceneInput::File { path, options: checkpoint.scene.options.clone() };
                Ok((input, Some(Resumed { file, checkpoint, is_asked: true })))
            }
        }
    }
}

/// File of the scene that a checkpoint names.
///
/// # Errors
/// Where there is no such file.
fn scene_of(checkpoint: &SavedCheckpoint) -> Result<PathBuf> {
    let path = PathBuf::from(&checkpoint.scene.path);
    match path.try_exists() {
        Ok(false) => {
            let message = format!(
                "{}: the scene of the checkpoint is not there; name its new place with --scene",
                path.display()
            );
            Err(Error::Settings(message))
        }
        _ => Ok(path),
    }
}

impl Resumed {
    fn found(file: PathBuf) -> Result<Self> {
        let checkpoint = SavedCheckpoint::open(&file).map_err(|error| {
            let message = "the file exists and is no checkpoint that can be resumed; give another name";
            Error::checkpoint(&file, format!("{message} ({error})"))
        })?;
        Ok(Self { file, checkpoint, is_asked: false })
    }
}

impl<'a> SceneInput<'a> {
    /// The scene. Meshes whose files have not changed are taken from those that were `kept`.
    pub(super) fn load(&self, kept: Option<&KeptMeshes>, watch: &Watch<'_>) -> Result<Cow<'a, Scene>> {
        // Only this part of the watch can be shared between threads.
        let events = watch.events;
        match self {
            Self::Memory(scene) => {
                scene.check()?;
                Ok(Cow::Borrowed(scene))
            }
            Self::Read { scene, .. } => Ok(Cow::Borrowed(scene)),
            Self::File { path, options } => {
                let show = |progress| events(Event::Preparing(Preparation::Scene(progress)));
                let scene = match kept {
                    Some(kept) => scene::load_keeping(path, options, &show, kept),
                    None => scene::load_with_progress(path, options, &show),
                };
                scene.map(Cow::Owned)
            }
        }
    }

    /// The scene's file, if the caller has named its folder.
    pub(super) fn in_folder(self, watch: &Watch<'_>) -> Result<Self> {
        let Self::File { path, options } = self else { return Ok(self) };
        let file = scene::scene_file(&path)?;
        if file != path {
            watch.tell(Event::Note(&format!("{} is a folder; its {} is rendered", path.display(), file.display())));
        }
        Ok(Self::File { path: file, options })
    }

    /// Absolute path of the file.
    pub(super) fn absolute_path(&self) -> Option<PathBuf> {
        match self {
            Self::File { path, .. } | Self::Read { path, .. } => std::path::absolute(path).ok(),
            Self::Memory(_) => None,
        }
    }

    /// File of the scene, with the choices with which it is read.
    pub(super) fn source(&self) -> Option<(PathBuf, LoadOptions)> {
        match self {
            Self::File { path, options } | Self::Read { path, options, .. } => Some((path.clone(), options.clone())),
            Self::Memory(_) => None,
        }
    }
}
