//! Reads a Mitsuba XML scene.

use std::path::Path;

use super::Scene;
use crate::Result;

/// What the caller overrides while a scene is read.
#[derive(Debug, Clone, Default)]
pub struct LoadOptions {
    /// `-D name=value`: replaces the scene's `<default>` of that name.
    pub defines: Vec<(String, String)>,
}

/// Reads the scene at `path` with everything it includes.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let _ = (path, options);
    todo!()
}
