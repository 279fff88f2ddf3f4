//! `--kernel-dir`: kernels from files in place of the built-in ones.

use std::path::{Path, PathBuf};

use lodestar::Result;
use lodestar::generated::kernels::{BackEnd, Registry};
use lodestar::spirv::replace::{self, Replacement};
use xxhash_rust::xxh3::xxh3_128;

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

    /// Says which files a render with this back end leaves aside.
    pub fn warn_of_unused(&self, back_end: BackEnd) {
        let used = self.replacement.files_of(back_end);
        for file in self.replacement.files.iter().filter(|file| !used.contains(&file.as_str())) {
            let reads = match back_end {
                BackEnd::Texel => "texel",
                BackEnd::Storage => "storage",
            };
            let path = self.folder.join(file);
            report("warning", &format!("{}: not used, for this render reads {reads} buffers", path.display()));
        }
    }

    /// The files that a render with this back end uses, each with the XXH3-128 of what it holds, wherever they lie.
    pub fn replaced(&self, back_end: BackEnd) -> Vec<String> {
        let used = self.replacement.files_of(back_end);
        let kernels = self.registry().kernels(back_end).iter().filter(|kernel| used.contains(&kernel.file));
        kernels.map(|kernel| format!("{} {:032x}", kernel.file, xxh3_128(&kernel.spirv))).collect()
    }
}
