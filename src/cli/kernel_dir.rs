//! `--kernel-dir`: kernels from files in place of the built-in ones.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lodestar::Result;
use lodestar::bvh::Bvh;
use lodestar::gpu::Context;
use lodestar::inspect::replace::{self, Replacement};
use lodestar::kernels::{BackEnd, Registry};
use lodestar::renderer::Renderer;
use lodestar::scene::Scene;
use lodestar::settings::Settings;

use super::report;

/// The kernels of a run.
pub struct KernelDir {
    folder: PathBuf,
    replacement: Replacement,
}

impl KernelDir {
    /// Reads the folder, if one is named, and says what is odd about it.
    pub fn load(folder: Option<&Path>) -> Result<Self> {
        let none = || Replacement { registry: Registry::built_in(), files: Vec::new(), warnings: Vec::new() };
        let replacement = folder.map_or_else(|| Ok(none()), replace::load)?;
        replacement.warnings.iter().for_each(|warning| report("warning", warning));
        Ok(Self { folder: folder.unwrap_or(Path::new("")).to_path_buf(), replacement })
    }

    pub fn registry(&self) -> &Registry {
        &self.replacement.registry
    }

    /// A renderer with these kernels.
    pub fn renderer(&self, context: &Arc<Context>, scene: &Scene, bvh: &Bvh, settings: &Settings) -> Result<Renderer> {
        let renderer = Renderer::with_kernels(context, scene, bvh, settings, self.registry())?;
        let used = self.replacement.files_of(renderer.back_end());
        for file in self.replacement.files.iter().filter(|file| !used.contains(&file.as_str())) {
            let reads = match renderer.back_end() {
                BackEnd::Texel => "texel",
                BackEnd::Storage => "storage",
            };
            let path = self.folder.join(file);
            report("warning", &format!("{}: not used, for this render reads {reads} buffers", path.display()));
        }
        Ok(renderer)
    }

    /// The files that a render with this back end uses.
    pub fn replaced(&self, back_end: BackEnd) -> Vec<String> {
        let files = self.replacement.files_of(back_end).into_iter();
        files.map(|file| self.folder.join(file).display().to_string()).collect()
    }
}
