//! Mitsuba's `serialized` meshes, versions 3 and 4: several compressed meshes, then a table of their offsets.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Take};
use std::path::Path;

use flate2::bufread::ZlibDecoder;
use glam::Vec2;

use super::triangles::{MAX_TRIANGLES, Mesh};
use crate::scene::inflate;
use crate::{Error, Result, inputs};

const MAGIC: u64 = 0x041c;
/// Flags: attributes that the mesh has, and whether its numbers are doubles. The flag for flat shading (0x10) is
/// ignored, as in Mitsuba 3.
const NORMALS: u32 = 0x1;
const UVS: u32 = 0x2;
const COLORS: u32 = 0x8;
const DOUBLES: u32 = 0x2000;

/// Reads mesh number `index` of the file at `path`, and no other.
pub(super) fn read(path: &Path, index: usize) -> Result<Mesh> {
    let (file, length) = inputs::open(path)?;
    read_mesh(BufReader::new(file), length, index).map_err(|message| Error::scene(path, None, message))
}

/// Number of triangles that mesh number `index` of the file at `path` promises; `None` where it cannot be read.
pub(super) fn promised_triangles(path: &Path, index: usize) -> Option<u64> {
    let (file, length) = inputs::open(path).ok()?;
    let (mut stream, version) = stream_of(BufReader::new(file), length, index).ok()?;
    stream.head(version).ok().map(|head| head.triangle_count as u64)
}

fn read_mesh<R: BufRead + Seek>(file: R, length: u64, index: usize) -> Result<Mesh, String> {
    let (mut stream, version) = stream_of(file, length, index)?;
    stream.mesh(version)
}

/// Content of mesh number `index`, and the file's version.
fn stream_of<R: BufRead + Seek>(
    mut file: R,
    length: u64,
    index: usize,
) -> Result<(Stream<ZlibDecoder<R>>, u64), String> {
    let version = version(&mut file).ok_or("this is not a serialized mesh: its first bytes are wrong")?;
    if version != 3 && version != 4 {
        return Err(format!("version {version} of serialized meshes is not supported; write 3 or 4"));
    }
    if index > 0 {
        let offset = offset(&mut file, version, index)?;
        let own = file.seek(SeekFrom::Start(offset)).ok().and_then(|_| self::version(&mut file));
        if own != Some(version) {
            return Err(format!("the table of meshes is wrong: no mesh begins at the offset of number {index}"));
        }
    }
    let content = ZlibDecoder::new(file).take(inflate::most_bytes(length));
    Ok((Stream { bytes: BufReader::new(content), doubles: false }, version))
}

/// Version in a mesh's header; `None` where it is no serialized mesh.
fn version(file: &mut impl Read) -> Option<u64> {
    let header: [u8; 4] = take(file).ok()?;
    (number(&header[..2]) == MAGIC).then(|| number(&header[2..]))
}

/// Offset of a mesh in bytes. The table of offsets stands at the end of the file, followed by its number of entries.
fn offset<R: Read + Seek>(file: &mut R, version: u64, index: usize) -> Result<u64, String> {
    let cut = |_| "the table of meshes at the end is cut short".to_string();
    let count_at = file.seek(SeekFrom::End(-4)).map_err(cut)?;
    let count = number(&take::<4>(file).map_err(cut)?);
    if index as u64 >= count {
        return Err(format!("`shape_index` {index} is out of range; the file has {count} meshes"));
    }
    let size = if version == 3 { 4 } else { 8 };
    let at =
        count_at.checked_sub((count - index as u64) * size).ok_or("the table of meshes at the end is cut short")?;
    file.seek(SeekFrom::Start(at)).map_err(cut)?;
    if version == 3 { take::<4>(file).map(|entry| number(&entry)) } else { take::<8>(file).map(|entry| number(&entry)) }
        .map_err(cut)
}

fn take<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Little-endian number of up to eight bytes.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte))
}

/// What stands before the vertices of a mesh.
struct Head {
    flags: u32,
    vertex_count: usize,
    triangle_count: usize,
}

/// Decompressed content of a mesh.
struct Stream<R> {
    bytes: BufReader<Take<R>>,
    doubles: bool,
}

impl<R: Read> Stream<R> {
    /// Reads what stands before the vertices.
    fn head(&mut self, version: u64) -> Result<Head, String> {
        let flags = number(&self.take::<4>()?) as u32;
        self.doubles = flags & DOUBLES != 0;
        if version >= 4 {
            while self.take::<1>()? != [0] {}
        }
        Ok(Head { flags, vertex_count: self.count("vertices")?, triangle_count: self.count("triangles")? })
    }

    fn mesh(&mut self, version: u64) -> Result<Mesh, String> {
        let Head { flags, vertex_count, triangle_count } = self.head(version)?;
        let mut mesh = Mesh { positions: self.vectors(vertex_count)?, ..Mesh::default() };
        if flags & NORMALS != 0 {
            mesh.normals = self.vectors(vertex_count)?;
        }
        if flags & UVS != 0 {
            mesh.uvs = self.vectors::<2, Vec2>(vertex_count)?;
        }
        if flags & COLORS != 0 {
            self.skip_vectors(vertex_count)?;
        }
        for _ in 0..triangle_count {
            mesh.triangles.push(self.triangle(vertex_count)?);
        }
        Ok(mesh)
    }

    /// Reads a count and checks it against the largest mesh: few compressed bytes may expand to many.
    fn count(&mut self, what: &str) -> Result<usize, String> {
        let count = number(&self.take::<8>()?);
        let limit = 3 * MAX_TRIANGLES;
        usize::try_from(count)
            .ok()
            .filter(|&count| count <= limit)
            .ok_or_else(|| format!("the mesh claims to have {count} {what}; no more than {limit} are read"))
    }

    fn vectors<const N: usize, V: From<[f32; N]>>(&mut self, count: usize) -> Result<Vec<V>, String> {
        // The vector grows as data arrives, because the count is not trusted.
        let mut vectors = Vec::new();
        for _ in 0..count {
            let mut vector = [0.0; N];
            for number in &mut vector {
                *number = self.float()?;
            }
            vectors.push(vector.into());
        }
        Ok(vectors)
    }

    fn skip_vectors(&mut self, count: usize) -> Result<(), String> {
        (0..3 * count).try_for_each(|_| self.float().map(drop))
    }

    fn triangle(&mut self, vertex_count: usize) -> Result<[u32; 3], String> {
        let mut triangle = [0; 3];
        for index in &mut triangle {
            *index = number(&self.take::<4>()?) as u32;
            if *index as usize >= vertex_count {
                return Err(format!("vertex index {index} is out of range; the mesh has {vertex_count}"));
            }
        }
        Ok(triangle)
    }

    fn float(&mut self) -> Result<f32, String> {
        let number = match self.doubles {
            true => f64::from_le_bytes(self.take()?) as f32,
            false => f32::from_le_bytes(self.take()?),
        };
        if number.is_finite() { Ok(number) } else { Err("a number of the mesh is not finite".to_string()) }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        take(&mut self.bytes).map_err(|error| match self.bytes.get_ref().limit() {
            0 => inflate::TOO_LONG.to_owned(),
            _ => format!("the mesh ends too early or is damaged: {error}"),
        })
    }
}
