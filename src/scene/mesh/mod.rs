//! Mesh files, kept in object space.

mod obj;
mod ply;
mod serialized;
mod words;

use std::path::Path;

use glam::{Vec2, Vec3};

use crate::{Error, Result};

/// Meshes are kept whole while they are read; a larger file is a mistake.
const MAX_FILE_BYTES: u64 = 8 << 30;

/// Triangles of a scene at most, copies of instances included: what the devices at hand can address, three texels each.
pub(super) const MAX_TRIANGLES: usize = 1 << 25;

/// Says that a face is a point or a line.
pub(super) const TOO_FEW_VERTICES: &str = "a face needs at least three vertices";

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
}

/// A kind of mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum MeshFormat {
    Obj,
    Ply,
    /// Mitsuba's own, and which of the file's meshes.
    Serialized(usize),
}

/// Reads the mesh file at `path`.
pub(super) fn read(path: &Path, format: MeshFormat) -> Result<Mesh> {
    let mesh = match format {
        MeshFormat::Obj => obj::parse(path, &bytes(path)?)?,
        MeshFormat::Ply => ply::parse(path, &bytes(path)?)?,
        MeshFormat::Serialized(index) => serialized::read(path, index)?,
    };
    if mesh.triangles.is_empty() {
        return Err(Error::scene(path, None, "the mesh has no faces: is the file cut short?"));
    }
    Ok(mesh)
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    let size = path.metadata().map_err(Error::read(path))?.len();
    if size > MAX_FILE_BYTES {
        let message = format!("a mesh file of {size} bytes is refused; the limit is {MAX_FILE_BYTES}");
        return Err(Error::scene(path, None, message));
    }
    std::fs::read(path).map_err(Error::read(path))
}

/// Cuts a polygon into triangles around its first vertex.
pub(super) fn add_polygon<T: Copy>(triangles: &mut Vec<[T; 3]>, polygon: &[T]) -> Result<(), String> {
    if polygon.len() < 3 {
        return Err(TOO_FEW_VERTICES.to_string());
    }
    triangles.extend(polygon[1..].windows(2).map(|pair| [polygon[0], pair[0], pair[1]]));
    Ok(())
}
