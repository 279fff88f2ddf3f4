//! The scene of a session and the kernels that render it.

use std::path::PathBuf;
use std::sync::Arc;

use crate::encode::bvh::Bvh;
use crate::scene::fingerprint::with_camera;
use crate::scene::{Camera, EnvironmentChoice, KeptMeshes, LoadOptions};
use crate::session::checkpoint::SceneSource;
use crate::session::files::absolute_path;
use crate::session::kernel_files::KernelFiles;
use crate::session::options::Options;
use crate::session::statistics::SetupTimes;
use crate::settings::Settings;
use crate::{Error, Result};

/// The scene and the kernels of a render. They outlive its film and its guide.
pub(super) struct Subject {
    pub scene_name: String,
    pub scene_path: PathBuf,
    pub scene_hash: String,
    /// Fingerprint of the scene without its camera and film.
    pub world_hash: String,
    /// Fingerprint of the scene's geometry.
    pub geometry: u128,
    /// Hierarchy of the scene, kept from the first change of the scene on.
    pub bvh: Option<Arc<Bvh>>,
    /// Meshes of the scene's files, kept from the first change of the scene on.
    pub meshes: KeptMeshes,
    /// File of the scene, with the choices with which it is read; `None` for a scene made in memory.
    pub source: Option<(PathBuf, LoadOptions)>,
    /// Files that stand in for built-in kernels, with their hashes.
    pub kernels: Vec<String>,
    pub kernel_files: KernelFiles,
    /// What the caller has chosen about the render of any scene.
    pub options: Options,
    pub times: SetupTimes,
    /// Whether the scene, the camera or the size of the film was changed after the beginning.
    pub is_changed: bool,
}

impl Subject {
    /// Facts in which all ranks must agree.
    pub fn facts(&self, settings: &Settings) -> Vec<(String, String)> {
        let facts = [
            ("version".into(), env!("CARGO_PKG_VERSION").into()),
            ("scene_hash".into(), self.scene_hash.clone()),
            ("kernels".into(), self.kernels.join(", ")),
        ];
        facts.into_iter().chain(settings.named()).collect()
    }

    /// Notes another view, whose camera is given if it was changed.
    pub fn change_view(&mut self, camera: Option<&Camera>) -> Result<()> {
        self.is_changed = true;
        if let Some(camera) = camera {
            self.scene_hash = with_camera(&self.scene_hash, camera)?;
        }
        Ok(())
    }

    /// The scene as a checkpoint names it.
    ///
    /// # Errors
    /// Where the scene was made in memory, or it or its view was changed, or a path is not UTF-8.
    pub fn scene_source(&self) -> Result<SceneSource> {
        if self.is_changed {
            let message = "a checkpoint needs the scene, the camera and the size that the render began with, but they were changed";
            return Err(Error::Settings(message.into()));
        }
        let Some((path, options)) = &self.source else {
            return Err(Error::Settings(
                "a checkpoint needs a scene that is read from a file, but this scene was made in memory".into(),
            ));
        };
        let mut options = options.clone();
        if let Some(EnvironmentChoice::File(path)) = &mut options.environment {
            *path = absolute_path(path)?.into();
        }
        Ok(SceneSource {
            path: absolute_path(path)?,
            options,
            hash: self.scene_hash.clone(),
            world_hash: self.world_hash.clone(),
        })
    }

    /// Refuses to go on with other kernels than before, because the bits would differ.
    pub fn check_kernels(&self, before: &[String]) -> Result<()> {
        if before == self.kernels {
            return Ok(());
        }
        let list = |kernels: &[String]| match kernels {
            [] => "the built-in kernels".to_owned(),
            kernels => kernels.join(", "),
        };
        Err(Error::Settings(format!(
            "the render began with {}, but would go on with {}: give the same --kernel-dir",
            list(before),
            list(&self.kernels)
        )))
    }
}
