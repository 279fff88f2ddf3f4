//! Mesh files, kept in object space.

pub(super) mod curves;
mod obj;
mod ply;
mod ply_attributes;
pub(super) mod ply_writer;
pub(super) mod rings;
mod serialized;
mod triangles;
mod tubes;
mod words;

use std::borrow::Cow;
use std::path::Path;

use crate::scene::text;
use crate::{Error, Result, inputs};

use curves::CurveFormat;
pub(super) use triangles::{Cutter, MAX_TRIANGLES, Mesh, MeshAttribute, VERTEX_COLOR, set_attribute};
pub(super) use tubes::{Strand, of_strands};

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

/// Reads the mesh file at `path`, with those of the `attributes` that it has.
pub(super) fn read(path: &Path, format: MeshFormat, attributes: &[&str]) -> Result<Mesh> {
    let mesh = match format {
        MeshFormat::Obj => obj::parse(path, &plain_text(&bytes(path)?))?,
        MeshFormat::Ply => ply::parse(path, &bytes(path)?, attributes)?,
        MeshFormat::Serialized(index) => serialized::read(path, index)?,
        MeshFormat::Curves(curves) => curves::parse(path, &plain_text(&bytes(path)?), &curves)?,
        MeshFormat::Memory(_) => Mesh::default(),
    };
    if mesh.triangles.is_empty() {
        let message = match (mesh.positions.len(), mesh.left_out) {
            (0, _) => "the mesh has no faces: is the file cut short?".to_owned(),
            (points, 0) => format!(
                "the mesh has {points} points, but no faces, of which lodestar renders triangles; save it with faces"
            ),
            (_, faces) => format!(
                "the {faces} faces of the mesh are points or lines; save it with faces of three corners or more"
            ),
        };
        return Err(Error::scene(path, None, message));
    }
    Ok(mesh)
}

/// Number of faces that the beginning of a mesh file promises, where its format tells it and the file can be read.
pub(super) fn promised_faces(path: &Path, format: MeshFormat) -> Option<u64> {
    match format {
        MeshFormat::Ply => ply::promised_faces(inputs::open(path).ok()?.0),
        MeshFormat::Serialized(index) => serialized::promised_triangles(path, index),
        MeshFormat::Obj | MeshFormat::Curves(_) | MeshFormat::Memory(_) => None,
    }
}

/// Warning about the faces of a file that were left out.
pub(super) fn warning(path: &Path, mesh: &Mesh) -> Option<String> {
    let count = mesh.left_out;
    let are = if count == 1 { "a face is a point or a line and is" } else { "faces are points or lines and are" };
    (count > 0).then(|| {
        format!("{}: {}{are} left out", path.display(), if count == 1 { String::new() } else { format!("{count} ") })
    })
}

/// Reads the mesh of the PLY file at `path`, which holds `bytes`.
pub(super) fn parse_ply(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    ply::parse(path, bytes, &[])
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    inputs::read(path, MAX_FILE_BYTES)
}

/// Text of a mesh without a byte order mark. Where lines end as on old Macs, by CR alone, they end by LF.
fn plain_text(bytes: &[u8]) -> Cow<'_, [u8]> {
    let bytes = text::without_mark(bytes);
    match bytes.contains(&b'\r') && !bytes.contains(&b'\n') {
        true => bytes.iter().map(|&byte| if byte == b'\r' { b'\n' } else { byte }).collect(),
        false => bytes.into(),
    }
}
