//! Mesh files, kept in object space.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::obj;
use crate::{Error, Result};

/// Meshes are kept whole while they are read; a larger file is a mistake.
const MAX_FILE_BYTES: u64 = 8 << 30;

/// One mesh. Vertices that differ in anything are different ones, as in Mitsuba, so that smooth normals do not go across
/// seams of the texture.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub positions: Vec<Vec3>,
    /// One per vertex, of any length, zero where the file gives none; empty where it gives none at all.
    pub normals: Vec<Vec3>,
    /// One per vertex, as in the file; empty where it has none.
    pub uvs: Vec<Vec2>,
    /// Indices of vertices.
    pub triangles: Vec<[u32; 3]>,
    /// The file asks for flat shading.
    pub face_normals: bool,
}

/// A kind of mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum MeshFormat {
    Obj,
}

/// Reads the mesh file at `path`.
pub(super) fn read(path: &Path, format: MeshFormat) -> Result<Mesh> {
    let size = path.metadata().map_err(Error::read(path))?.len();
    if size > MAX_FILE_BYTES {
        let message = format!("a mesh file of {size} bytes is refused; the limit is {MAX_FILE_BYTES}");
        return Err(Error::scene(path, None, message));
    }
    let bytes = std::fs::read(path).map_err(Error::read(path))?;
    let mesh = match format {
        MeshFormat::Obj => obj::parse(path, &bytes)?,
    };
    if mesh.triangles.is_empty() {
        return Err(Error::scene(path, None, "the mesh has no faces: is the file cut short?"));
    }
    Ok(mesh)
}
