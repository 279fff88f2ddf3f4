//! Kernels from files in place of the built-in ones.

use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::xxh3_128;

use crate::Result;
use crate::generated::kernels::{BackEnd, Registry};
use crate::spirv::replace::{self, Replacement};

/// The kernels of a render.
pub struct KernelFiles {
    folder: PathBuf,
    replacement: Replacement,
}

impl KernelFiles {
    /// Reads the kernels of a folder; without one, all kernels are the built-in ones.
    ///
    /// # Errors
    /// Where a file cannot be read or cannot stand in for a kernel.
    pub fn load(folder: Option<&Path>) -> Result<Self> {
        let none = || Replacement { registry: Registry::built_in(), files: Vec::new(), warnings: Vec::new() };
        let replacement = folder.map_or_else(|| Ok(none()), replace::load)?;
        Ok(Self { folder: folder.unwrap_or(Path::new("")).to_path_buf(), replacement })
    }

    /// All kernels: each from its file if there is one, otherwise built in.
    pub fn registry(&self) -> &Registry {
        &self.replacement.registry
    }

    /// One sentence for each file that was ignored or could not be checked.
    pub fn warnings(&self) -> &[String] {
        &self.replacement.warnings
    }

    /// One sentence for each file that a render with this back end does not use.
    pub fn unused(&self, back_end: BackEnd) -> Vec<String> {
        let used = self.replacement.files_of(back_end);
        let reads = match back_end {
            BackEnd::Texel => "texel buffers",
            BackEnd::Storage => "storage buffers",
            BackEnd::Query => "an acceleration structure and storage buffers",
        };
        let unused = self.replacement.files.iter().filter(|file| !used.contains(&file.as_str()));
        unused
            .map(|file| {
                let path = self.folder.join(file);
                format!("{}: not used, because this render reads {reads}", path.display())
            })
            .collect()
    }

    /// Names of the files that a render with this back end uses, each with the XXH3-128 of its contents.
    pub fn used(&self, back_end: BackEnd) -> Vec<String> {
        let used = self.replacement.files_of(back_end);
        let kernels = self.registry().kernels(back_end).iter().filter(|kernel| used.contains(&kernel.file));
        kernels.map(|kernel| format!("{} {:032x}", kernel.file, xxh3_128(&kernel.spirv))).collect()
    }
}
