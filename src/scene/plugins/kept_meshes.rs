//! Meshes of files that stay in memory from one reading of a scene to the next.

use std::collections::HashMap;
use std::fs::Metadata;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use super::shape::MeshFile;
use crate::Result;
use crate::scene::mesh::Mesh;

/// Meshes of the scene that was read last. A file is read again if its length or the time of its last change differs.
#[derive(Default)]
pub(crate) struct KeptMeshes(Mutex<HashMap<MeshFile, Kept>>);

/// Mesh of a file.
struct Kept {
    state: FileState,
    /// Attributes with which the mesh was read.
    attributes: Vec<String>,
    mesh: Arc<Mesh>,
}

/// What tells that a file has not changed.
#[derive(Clone, Copy, PartialEq)]
struct FileState {
    length: u64,
    changed: SystemTime,
}

impl FileState {
    /// State of the file at `path`; `None` where the system does not tell it.
    fn of(path: &Path) -> Option<Self> {
        let metadata: Metadata = path.metadata().ok()?;
        Some(Self { length: metadata.len(), changed: metadata.modified().ok()? })
    }
}

impl KeptMeshes {
    /// The mesh of a file, which `read` reads where it is not kept.
    ///
    /// # Errors
    /// Where `read` fails.
    pub(super) fn get_or_read(
        &self,
        file: &MeshFile,
        attributes: &[&str],
        read: impl FnOnce() -> Result<Mesh>,
    ) -> Result<Arc<Mesh>> {
        // A file that changes while it is read has another state than this one afterwards.
        let state = FileState::of(&file.path);
        let is_it = |kept: &&Kept| Some(kept.state) == state && kept.attributes == attributes;
        let known = self.kept().get(file).filter(is_it).map(|kept| Arc::clone(&kept.mesh));
        if let Some(mesh) = known {
            return Ok(mesh);
        }
        let mesh = Arc::new(read()?);
        if let Some(state) = state {
            let attributes = attributes.iter().map(|&name| name.to_owned()).collect();
            self.kept().insert(file.clone(), Kept { state, attributes, mesh: Arc::clone(&mesh) });
        }
        Ok(mesh)
    }

    /// Forgets all meshes but these.
    pub(super) fn keep_only(&self, meshes: &HashMap<MeshFile, Arc<Mesh>>) {
        self.kept().retain(|file, _| meshes.contains_key(file));
    }

    fn kept(&self) -> MutexGuard<'_, HashMap<MeshFile, Kept>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::fs;

    use super::*;
    use crate::scene::mesh::MeshFormat;

    /// A file is read once, and again after it has changed, with other attributes, or once it was forgotten.
    #[test]
    fn a_file_is_read_again_only_if_it_has_changed() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = MeshFile { path: folder.path().join("a.ply"), format: MeshFormat::Ply };
        let (kept, count) = (KeptMeshes::default(), Cell::new(0));
        let reads = |attributes: &[&str]| {
            let before = count.get();
            let read = || {
                count.set(before + 1);
                Ok(Mesh::default())
            };
            kept.get_or_read(&file, attributes, read).expect("a mesh");
            count.get() - before
        };
        fs::write(&file.path, "one").expect("a file");
        assert_eq!((reads(&[]), reads(&[])), (1, 0));
        assert_eq!((reads(&["face_color"]), reads(&["face_color"])), (1, 0));
        fs::write(&file.path, "longer").expect("a file");
        assert_eq!((reads(&["face_color"]), reads(&["face_color"])), (1, 0));
        let later = SystemTime::now() + std::time::Duration::from_secs(9);
        fs::File::options().write(true).open(&file.path).and_then(|file| file.set_modified(later)).expect("a time");
        assert_eq!((reads(&["face_color"]), reads(&["face_color"])), (1, 0));
        kept.keep_only(&HashMap::from([(file.clone(), Arc::default())]));
        assert_eq!(reads(&["face_color"]), 0);
        kept.keep_only(&HashMap::new());
        assert_eq!(reads(&["face_color"]), 1);
        // What fails is not kept, and what is missing is not looked for among what is kept.
        fs::remove_file(&file.path).expect("a file");
        assert_eq!((reads(&["face_color"]), reads(&["face_color"])), (1, 1));
    }
}
