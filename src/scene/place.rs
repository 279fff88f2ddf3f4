//! Place of a scene: its file, or the folder that holds it.

use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// Name of the scene's file in a folder that stands for a scene.
const FILE_IN_FOLDER: &str = "scene.xml";

/// File of the scene at `path`: `path` itself, or `scene.xml` in it if it is a folder.
///
/// # Errors
/// [`Error::Scene`] where the folder has no `scene.xml`.
pub fn scene_file(path: &Path) -> Result<PathBuf> {
    if !path.is_dir() {
        return Ok(path.to_path_buf());
    }
    let file = path.join(FILE_IN_FOLDER);
    match file.is_file() {
        true => Ok(file),
        false => Err(Error::scene(path, None, "it is a folder without a scene.xml; name the scene's file in it")),
    }
}
