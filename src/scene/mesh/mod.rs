//! Mesh files, kept in object space.

pub(super) mod curves;
mod obj;
mod ply;
pub(super) mod ply_writer;
pub(super) mod rings;
mod serialized;
mod triangles;
mod tubes;
mod words;

use std::path::Path;

use crate::{Error, Result, inputs};

use curves::CurveFormat;
pub(super) use triangles::{MAX_TRIANGLES, Mesh};

/// Largest mesh file in bytes. Meshes are kept whole while they are read, and a larger file is a mistake.
const MAX_FILE_BYTES: u64 = 8 << 30;

/// Formats of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum MeshFormat {
    Obj,
    Ply,
    /// Mitsuba's `serialized` format, with the index of the mesh within the file.
    Serialized(usize),
    /// Mitsuba's text files of curves.
    Curves(CurveFormat),
    /// No file: a mesh in memory, with its index.
    Memory(usize),
}

/// Reads the mesh file at `path`.
pub(super) fn read(path: &Path, format: MeshFormat) -> Result<Mesh> {
    let mesh = match format {
        MeshFormat::Obj => obj::parse(path, &bytes(path)?)?,
        MeshFormat::Ply => ply::parse(path, &bytes(path)?)?,
        MeshFormat::Serialized(index) => serialized::read(path, index)?,
        MeshFormat::Curves(curves) => curves::parse(path, &bytes(path)?, &curves)?,
        MeshFormat::Memory(_) => Mesh::default(),
    };
    if mesh.triangles.is_empty() {
        return Err(Error::scene(path, None, "the mesh has no faces: is the file cut short?"));
    }
    Ok(mesh)
}

/// Reads the mesh of the PLY file at `path`, which holds `bytes`.
pub(super) fn parse_ply(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    ply::parse(path, bytes)
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    inputs::read(path, MAX_FILE_BYTES)
}
