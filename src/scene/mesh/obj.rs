//! Wavefront OBJ: positions, texture coordinates, normals and faces. Other lines are skipped. Grouping is skipped too, so smooth
//! normals continue across objects, as in Mitsuba.

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::triangles::{Cutter, MAX_TRIANGLES, Mesh};
use super::words::Words;
use crate::{Error, Result, quoted};

/// Reads the mesh in the OBJ file at `path`, which holds `text`.
pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Mesh> {
    if let Ok(mesh) = Reader::new(text, None).mesh() {
        return Ok(mesh);
    }
    // The second pass knows the totals and checks each index where it stands, so that the error names the first faulty line.
    let mut reader = Reader::new(text, Some(totals(text)));
    reader.mesh().map_err(|message| Error::scene(path, Some(reader.words.line()), message))
}

/// Numbers of positions, texture coordinates and normals in the file.
type Totals = [usize; 3];
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Most digits of an index that a number of 32 bits certainly holds.
const INDEX_DIGITS: u32 = 9;

/// Indices into positions, texture coordinates and normals, counted from 1; 0 where the corner has none.
type Corner = [u32; 3];

/// Kinds of lines, by their first word.
enum Keyword {
    /// Numbers of the kind with this index in [`KINDS`].
    Numbers(usize),
    Face,
    Other,
}

impl Keyword {
    fn of(words: &mut Words) -> Self {
        match words.next() {
            b"v" => Self::Numbers(0),
            b"vt" => Self::Numbers(1),
            b"vn" => Self::Numbers(2),
            b"f" => Self::Face,
            _ => Self::Other,
        }
    }
}

fn totals(text: &[u8]) -> Totals {
    let (mut totals, mut words) = ([0; 3], Words::new(text));
    loop {
        if let Keyword::Numbers(kind) = Keyword::of(&mut words) {
            totals[kind] += 1;
        }
        if !words.next_line() {
            return totals;
        }
    }
}

/// Content of a file, as far as it was read.
struct Reader<'a> {
    words: Words<'a>,
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Corners of all faces, in their order.
    corners: Vec<Corner>,
    /// Number of corners of each face; at least three.
    sizes: Vec<u32>,
    faces: usize,
    /// Number of faces that are points or lines.
    left_out: usize,
    /// Totals of the file, for the second pass only.
    totals: Option<Totals>,
}

impl<'a> Reader<'a> {
    fn new(text: &'a [u8], totals: Option<Totals>) -> Self {
        Self {
            words: Words::new(text),
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            corners: Vec::new(),
            sizes: Vec::new(),
            faces: 0,
            left_out: 0,
            totals,
        }
    }

    /// Reads the mesh. An error is about the current line, unless the totals are not known.
    fn mesh(&mut self) -> Result<Mesh, String> {
        loop {
            self.line()?;
            if !self.words.next_line() {
                break;
            }
        }
        let counts = self.counts().map(|count| count as u32);
        let is_within = |corner: &Corner| (0..3).all(|kind| corner[kind] <= counts[kind]);
        if !self.corners.iter().all(is_within) {
            return Err("an index is out of range".into());
        }
        let mut vertices = Vertices::new(self.positions.len());
        let indices: Vec<u32> = self.corners.iter().map(|&corner| vertices.index(corner)).collect();
        let corners = vertices.corners;
        let positions: Vec<Vec3> = corners.iter().map(|corner| self.positions[corner[0] as usize - 1]).collect();
        let (mut triangles, mut cutter) = (Vec::with_capacity(self.sizes.len()), Cutter::default());
        let mut rest = &indices[..];
        for &size in &self.sizes {
            let (polygon, others) = rest.split_at(size as usize);
            cutter.add(&mut triangles, polygon, &positions)?;
            rest = others;
        }
        Ok(Mesh {
            uvs: of_vertices(&corners, 1, &self.uvs),
            normals: of_vertices(&corners, 2, &self.normals),
            triangles,
            positions,
            left_out: self.left_out,
            ..Mesh::default()
        })
    }

    fn line(&mut self) -> Result<(), String> {
        match Keyword::of(&mut self.words) {
            Keyword::Numbers(0) => self.positions.push(self.words.floats()?.into()),
            Keyword::Numbers(1) => self.uvs.push(self.words.floats()?.into()),
            Keyword::Numbers(_) => self.normals.push(self.words.floats()?.into()),
            Keyword::Face => self.face()?,
            Keyword::Other => {}
        }
        Ok(())
    }

    fn face(&mut self) -> Result<(), String> {
        self.faces += 1;
        if self.faces > MAX_TRIANGLES {
            return Err(format!("no more than {MAX_TRIANGLES} faces fit"));
        }
        let first = self.corners.len();
        loop {
            match self.words.next() {
                [] | [b'#', ..] => break,
                word => {
                    let corner = match plain_corner(word) {
                        Some(corner) if self.totals.is_none() => corner,
                        _ => self.corner(word)?,
                    };
                    self.corners.push(corner);
                }
            }
        }
        let size = self.corners.len() - first;
        if size < 3 {
            self.left_out += 1;
            self.corners.truncate(first);
        } else {
            self.sizes.push(size as u32);
        }
        Ok(())
    }

    /// Numbers of positions, texture coordinates and normals read so far.
    fn counts(&self) -> Totals {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    /// Parses a corner: `position`, `position/uv`, `position//normal` or `position/uv/normal`.
    fn corner(&self, word: &[u8]) -> Result<Corner, String> {
        let word = String::from_utf8_lossy(word);
        let mut corner = [0; 3];
        for (kind, index) in word.split('/').enumerate() {
            if kind == 3 {
                return Err(format!("{} has too many indices", quoted::word(&word)));
            }
            if kind == 0 || !index.is_empty() {
                corner[kind] = self.index(kind, index).ok_or_else(|| self.not_an_index(kind, index, &word))?;
            }
        }
        Ok(corner)
    }

    /// Parses an index that counts from 1, or if negative back from the last one read. Returns it counted from 1.
    fn index(&self, kind: usize, index: &str) -> Option<u32> {
        let limit = self.totals.map_or(u32::MAX as usize, |totals| totals[kind]);
        let distance: isize = index.parse().ok()?;
        let index = if distance < 0 { self.counts()[kind] + 1 } else { 0 }.checked_add_signed(distance)?;
        (index != 0 && index <= limit).then_some(index as u32)
    }

    fn not_an_index(&self, kind: usize, index: &str, word: &str) -> String {
        let digits = index.strip_prefix(['-', '+']).unwrap_or(index);
        if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
            return format!("{} is not a vertex of a face", quoted::word(word));
        }
        let total = self.totals.map_or(0, |totals| totals[kind]);
        let index = if index.len() <= 40 { index } else { "of many digits" };
        format!("{} index {index} is out of range; the file has {total}", KINDS[kind])
    }
}

/// Parses a corner of the usual form, with indices that count from 1; `None` for any other.
fn plain_corner(word: &[u8]) -> Option<Corner> {
    let (mut corner, mut kind, mut digits) = ([0_u32; 3], 0, 0);
    for &byte in word {
        match byte {
            b'0'..=b'9' if digits < INDEX_DIGITS => {
                corner[kind] = 10 * corner[kind] + u32::from(byte - b'0');
                digits += 1;
            }
            // An index of 0 is refused, and so is a corner without a position.
            b'/' if kind < 2 && (digits == 0) == (corner[kind] == 0) && corner[0] != 0 => {
                kind += 1;
                digits = 0;
            }
            _ => return None,
        }
    }
    ((digits == 0) == (corner[kind] == 0) && corner[0] != 0).then_some(corner)
}

/// Numbers of one kind for each vertex, 0 where its corner has none; nothing where no corner has any.
fn of_vertices<T: Copy + Default>(corners: &[Corner], kind: usize, numbers: &[T]) -> Vec<T> {
    if corners.iter().all(|corner| corner[kind] == 0) {
        return Vec::new();
    }
    let of = |corner: &Corner| match corner[kind] {
        0 => T::default(),
        index => numbers[index as usize - 1],
    };
    corners.iter().map(of).collect()
}

/// Most vertices in the list of one position. Further ones are hashed, because a file may have any number of them.
const MOST_LISTED: usize = 16;
/// Index that no vertex has.
const NONE: u32 = u32::MAX;

/// Vertices of a mesh: the different corners, in the order in which they first occur.
struct Vertices {
    corners: Vec<Corner>,
    /// Vertex that was listed last, by position.
    newest: Vec<u32>,
    /// Vertex of the same position that was listed before, by vertex.
    older: Vec<u32>,
    /// Vertices that no list has.
    hashed: HashMap<Corner, u32>,
}

impl Vertices {
    fn new(positions: usize) -> Self {
        let newest = vec![NONE; positions];
        Self { corners: Vec::new(), newest, older: Vec::new(), hashed: HashMap::new() }
    }

    /// Index of the vertex at a corner, whose position is within range.
    fn index(&mut self, corner: Corner) -> u32 {
        let newest = &mut self.newest[corner[0] as usize - 1];
        let next = self.corners.len() as u32;
        let (mut at, mut listed) = (*newest, 0);
        while at != NONE {
            if self.corners[at as usize] == corner {
                return at;
            }
            at = self.older[at as usize];
            listed += 1;
        }
        let is_listed = listed < MOST_LISTED;
        if !is_listed {
            let known = *self.hashed.entry(corner).or_insert(next);
            if known != next {
                return known;
            }
        }
        self.older.push(if is_listed { *newest } else { NONE });
        if is_listed {
            *newest = next;
        }
        self.corners.push(corner);
        next
    }
}
