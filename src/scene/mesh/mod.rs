//! Mesh files, kept in object space.

mod obj;
mod ply;
mod serialized;
mod words;

use std::path::Path;

use glam::{Vec2, Vec3};

use crate::{Error, Result};

/// Largest mesh file in bytes. Meshes are kept whole while they are read, and a larger file is a mistake.
const MAX_FILE_BYTES: u64 = 8 << 30;

/// Most triangles of a scene, copies of instances included. Devices can address this many at three texels each.
pub(super) const MAX_TRIANGLES: usize = 1 << 25;

/// Message about a face that is a point or a line.
pub(super) const TOO_FEW_VERTICES: &str = "a face needs at least three vertices";

/// One mesh. Vertices that differ in any attribute are kept apart, as in Mitsuba, so that smooth normals do not cross
/// texture seams.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub positions: Vec<Vec3>,
    /// One normal per vertex, of any length, zero where the file gives none; empty where no vertex has one.
    pub normals: Vec<Vec3>,
    /// One texture coordinate per vertex, as in the file; empty where it has none.
    pub uvs: Vec<Vec2>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Formats of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum MeshFormat {
    Obj,
    Ply,
    /// Mitsuba's `serialized` format, with the index of the mesh within the file.
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
