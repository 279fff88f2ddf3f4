//! Count of the triangles of mesh files. A scene with too many is refused before its meshes are read, or after the first ones.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Result;
use crate::scene::description::origin::Origin;

/// Triangles of a scene's meshes, counted by several threads that read them.
pub(super) struct TriangleBudget {
    /// Most triangles of a scene.
    limit: usize,
    triangles: AtomicUsize,
    meshes: AtomicUsize,
}

impl TriangleBudget {
    /// A budget of `limit` triangles, of which meshes in memory take `taken`.
    pub fn new(limit: usize, taken: usize) -> Self {
        Self { limit, triangles: taken.into(), meshes: 0.into() }
    }

    /// Whether so many triangles were read that nothing else needs to be.
    pub fn is_spent(&self) -> bool {
        self.triangles.load(Ordering::Relaxed) > self.limit
    }

    /// Adds the triangles of the mesh file `name`, which was read for the shape at `origin`.
    ///
    /// # Errors
    /// Where this mesh is the one with which the scene has too many.
    pub fn add(&self, count: usize, name: &Path, origin: &Origin) -> Result<()> {
        let before = self.triangles.fetch_add(count, Ordering::Relaxed);
        let meshes = 1 + self.meshes.fetch_add(1, Ordering::Relaxed);
        let (all, limit) = (before.saturating_add(count), self.limit);
        if before > limit || all <= limit {
            return Ok(());
        }
        let name = name.display();
        Err(origin.error(format!(
            "with {name} the scene has {all} triangles so far, after {meshes} of its mesh files; no more than {limit} fit"
        )))
    }

    /// Refuses mesh files that promise too many triangles. They are in the order of the scene.
    ///
    /// # Errors
    /// At the first file with which there are too many.
    pub fn check_promised(&self, files: &[Promise<'_>]) -> Result<()> {
        let (limit, mut sum) = (self.limit, self.triangles.load(Ordering::Relaxed) as u64);
        let all = files.iter().fold(sum, |all, file| all.saturating_add(file.triangles));
        for &Promise { triangles, name, origin } in files {
            sum = sum.saturating_add(triangles);
            if sum > limit as u64 {
                let name = name.display();
                return Err(origin.error(format!(
                    "with {name} the scene has {sum} triangles or more, and {all} or more with all meshes; no more than {limit} fit"
                )));
            }
        }
        Ok(())
    }
}

/// Number of triangles that the beginning of a mesh file promises.
#[derive(Debug, Clone, Copy)]
pub(super) struct Promise<'a> {
    pub triangles: u64,
    pub name: &'a Path,
    /// Shape that names the file.
    pub origin: &'a Origin,
}
