//! Folders in which the files that a scene names are searched.

use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Folders in which the files that a scene names are searched.
#[derive(Debug)]
pub(super) struct Folders {
    /// Folder of the top scene file.
    top: PathBuf,
    /// Folders that `<path>` elements add, the latest last.
    added: Vec<PathBuf>,
}

/// File that a scene names.
#[derive(Debug, Clone)]
pub(super) struct FoundFile {
    /// Canonical path, or the name of a file in memory.
    pub path: PathBuf,
    /// Content of a file in memory.
    pub bytes: Option<Arc<[u8]>>,
}

impl Folders {
    /// Folders of the scene file at `scene`, without any that a `<path>` adds.
    pub fn new(scene: &Path) -> Self {
        Self { top: folder(scene), added: Vec::new() }
    }

    /// Adds the folder `name`, which is relative to the file that names it, or else to the top scene's folder. Returns
    /// false where neither exists.
    pub fn add(&mut self, name: &str, named_in: &Path) -> bool {
        let found = [folder(named_in).join(name), self.top.join(name)].into_iter().find(|path| path.is_dir());
        self.added.extend(found.clone());
        found.is_some()
    }

    /// Path of the file `name`; `None` where no folder has it. As in Mitsuba, the folders of `<path>` elements come
    /// first, the latest at their head. The folder of the file that names it and the top scene's folder follow.
    pub fn find(&self, name: &str, named_in: &Path) -> Option<PathBuf> {
        let own = folder(named_in);
        let folders = self.added.iter().rev().chain([&own, &self.top]);
        folders.map(|folder| folder.join(name)).find(|path| path.is_file())
    }
}

/// Folder of a file, never empty.
fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}
