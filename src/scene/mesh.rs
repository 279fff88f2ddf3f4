//! OBJ files, read by `tobj` and kept in object space, as one mesh each however many objects a file holds.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::mesh_fault;
use crate::{Error, Result};

/// One mesh file's content.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub positions: Vec<Vec3>,
    /// As in the file, not normalized; empty where it has none.
    pub normals: Vec<Vec3>,
    /// As in the file, not flipped; empty where it has none.
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[Corner; 3]>,
}

impl Mesh {
    fn is_finite(&self) -> bool {
        self.positions.iter().chain(&self.normals).all(|v| v.is_finite()) && self.uvs.iter().all(|uv| uv.is_finite())
    }
}

/// Indices of one triangle's corner; the last two mean nothing where the mesh has no such data.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    pub position: u32,
    pub normal: u32,
    pub uv: u32,
}

/// Reads the OBJ file at `path`.
pub(super) fn read(path: &Path) -> Result<Mesh> {
    let text = fs::read(path).map_err(Error::read(path))?;
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let mut reader = Cursor::new(without_grouping(&text));
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| Ok(Default::default()));
    let models = loaded.map_err(|error| mesh_fault::explain(path, &text, &error.to_string()))?.0;
    let mesh = models.first().map(|model| convert(&model.mesh)).unwrap_or_default();
    // What tobj lets pass: numbers that are none, and faces cut short.
    if !mesh.is_finite() || mesh_fault::has_short_face(&text) {
        return Err(mesh_fault::explain(path, &text, "malformed mesh"));
    }
    if mesh.triangles.is_empty() {
        return Err(mesh_fault::explain(path, &text, "the mesh has no faces: is the file cut short?"));
    }
    Ok(mesh)
}

/// Blanks the lines that would split the file into several models: smooth normals go across objects, as in Mitsuba.
fn without_grouping(text: &[u8]) -> Vec<u8> {
    let mut result = Vec::with_capacity(text.len());
    for line in text.split_inclusive(|&byte| byte == b'\n') {
        let word = line.trim_ascii().split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let groups = [&b"g"[..], b"o", b"usemtl", b"mtllib"].contains(&word);
        result.extend_from_slice(if groups { b"\n" } else { line });
    }
    result
}

fn convert(mesh: &tobj::Mesh) -> Mesh {
    let index = |indices: &[u32], at: usize| indices.get(at).copied().unwrap_or(0);
    let corner = |at: usize| Corner {
        position: mesh.indices[at],
        normal: index(&mesh.normal_indices, at),
        uv: index(&mesh.texcoord_indices, at),
    };
    Mesh {
        positions: mesh.positions.chunks_exact(3).map(Vec3::from_slice).collect(),
        normals: mesh.normals.chunks_exact(3).map(Vec3::from_slice).collect(),
        uvs: mesh.texcoords.chunks_exact(2).map(Vec2::from_slice).collect(),
        triangles: (0..mesh.indices.len() / 3).map(|i| [0, 1, 2].map(|k| corner(3 * i + k))).collect(),
    }
}
