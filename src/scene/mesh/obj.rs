//! Wavefront OBJ: positions, texture coordinates, normals and faces. All else, grouping too, is passed over: smooth
//! normals go across objects, as in Mitsuba.

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::words::Words;
use super::{Mesh, add_polygon};
use crate::{Error, Result};

/// Stands for an index that a corner lacks.
const NONE: u32 = u32::MAX;
/// Vertices at one position that are searched one by one; more are found by a hash.
const MAX_CHAIN: usize = 16;

/// The mesh in the OBJ file at `path`, which holds `text`.
pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Mesh> {
    let fault = |fault: Fault| Error::scene(path, Some(fault.line), fault.message);
    let mut obj = Obj::default();
    obj.read(text).map_err(fault)?;
    if !obj.has_valid_indices() {
        // A face may refer to what stands below it, so only now can the line be named.
        let mut strict = Obj { totals: Some(obj.totals()), ..Obj::default() };
        strict.read(text).map_err(fault)?;
    }
    Ok(obj.unify())
}

/// What is wrong, and in which line, counted from 1.
struct Fault {
    line: u32,
    message: String,
}

/// How many positions, texture coordinates and normals there are.
type Totals = [usize; 3];
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Indices into positions, texture coordinates and normals; the last two may be `NONE`.
type Corner = [u32; 3];

/// The file as it stands.
#[derive(Default)]
struct Obj {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    triangles: Vec<[Corner; 3]>,
    /// Largest index of each kind plus one, or more than there can be where one is out of range.
    used: Totals,
    /// Given where an index out of range is an error at once.
    totals: Option<Totals>,
}

impl Obj {
    fn read(&mut self, text: &[u8]) -> Result<(), Fault> {
        let mut words = Words::new(text);
        let mut polygon = Vec::new();
        loop {
            self.read_line(&mut words, &mut polygon).map_err(|message| Fault { line: words.line(), message })?;
            if !words.next_line() {
                return Ok(());
            }
        }
    }

    fn read_line(&mut self, words: &mut Words, polygon: &mut Vec<Corner>) -> Result<(), String> {
        match words.next() {
            b"v" => self.positions.push(words.floats()?.into()),
            b"vt" => self.uvs.push(words.floats()?.into()),
            b"vn" => self.normals.push(words.floats()?.into()),
            b"f" => self.read_face(words, polygon)?,
            _ => {}
        }
        Ok(())
    }

    fn read_face(&mut self, words: &mut Words, polygon: &mut Vec<Corner>) -> Result<(), String> {
        polygon.clear();
        loop {
            match words.next() {
                [] | [b'#', ..] => break,
                word => polygon.push(self.corner(word)?),
            }
        }
        add_polygon(&mut self.triangles, polygon)
    }

    /// `position`, `position/uv`, `position//normal` or `position/uv/normal`.
    fn corner(&mut self, word: &[u8]) -> Result<Corner, String> {
        let mut corner = [NONE; 3];
        let mut rest = word;
        for kind in 0..3 {
            let (index, after) = split_integer(rest);
            match index {
                Some(index) => corner[kind] = self.index(kind, index)?,
                None if kind > 0 && (after.is_empty() || after[0] == b'/') => {}
                None => return Err(not_a_corner(word)),
            }
            match after {
                [] => return Ok(corner),
                [b'/', more @ ..] => rest = more,
                _ => return Err(not_a_corner(word)),
            }
        }
        Err(format!("`{}` has too many indices", String::from_utf8_lossy(word)))
    }

    /// From 1, or relative to what has been read so far, to from 0.
    fn index(&mut self, kind: usize, index: i64) -> Result<u32, String> {
        let here = self.totals_so_far()[kind];
        let absolute = if index < 0 { here as i64 + index } else { index - 1 };
        let limit = self.totals.map_or(NONE as usize, |totals| totals[kind]);
        match usize::try_from(absolute) {
            Ok(absolute) if absolute < limit => {
                self.used[kind] = self.used[kind].max(absolute + 1);
                Ok(absolute as u32)
            }
            _ if self.totals.is_some() => {
                Err(format!("{} index {index} is out of range; the file has {limit}", KINDS[kind]))
            }
            _ => {
                self.used[kind] = usize::MAX;
                Ok(NONE)
            }
        }
    }

    fn totals_so_far(&self) -> Totals {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    fn totals(&self) -> Totals {
        self.totals_so_far()
    }

    fn has_valid_indices(&self) -> bool {
        self.used.iter().zip(self.totals()).all(|(&used, total)| used <= total)
    }

    /// The mesh whose vertices are the different corners.
    fn unify(self) -> Mesh {
        let mut vertices = Vertices::new(self.positions.len());
        let triangles = self.triangles.iter().map(|corners| corners.map(|corner| vertices.id(corner))).collect();
        let corners = vertices.corners;
        let [_, has_uvs, has_normals] = self.used.map(|used| used > 0);
        let uv = |corner: &Corner| self.uvs.get(corner[1] as usize).copied().unwrap_or_default();
        let normal = |corner: &Corner| self.normals.get(corner[2] as usize).copied().unwrap_or_default();
        Mesh {
            positions: corners.iter().map(|corner| self.positions[corner[0] as usize]).collect(),
            uvs: if has_uvs { corners.iter().map(uv).collect() } else { Vec::new() },
            normals: if has_normals { corners.iter().map(normal).collect() } else { Vec::new() },
            triangles,
        }
    }
}

/// Different corners, numbered in the order in which they come.
struct Vertices {
    corners: Vec<Corner>,
    /// The first vertex at each position, and the next one at the same position.
    first: Vec<u32>,
    next: Vec<u32>,
    hashed: HashMap<Corner, u32>,
}

impl Vertices {
    fn new(position_count: usize) -> Self {
        Self { corners: Vec::new(), first: vec![NONE; position_count], next: Vec::new(), hashed: HashMap::new() }
    }

    fn id(&mut self, corner: Corner) -> u32 {
        let position = corner[0] as usize;
        let mut id = self.first[position];
        for _ in 0..MAX_CHAIN {
            if id == NONE {
                let new = self.push(corner);
                self.next[new as usize] = std::mem::replace(&mut self.first[position], new);
                return new;
            }
            if self.corners[id as usize] == corner {
                return id;
            }
            id = self.next[id as usize];
        }
        if let Some(&id) = self.hashed.get(&corner) {
            return id;
        }
        let new = self.push(corner);
        self.hashed.insert(corner, new);
        new
    }

    fn push(&mut self, corner: Corner) -> u32 {
        self.corners.push(corner);
        self.next.push(NONE);
        self.corners.len() as u32 - 1
    }
}

fn not_a_corner(word: &[u8]) -> String {
    format!("`{}` is not a vertex of a face", String::from_utf8_lossy(word))
}

/// The integer at the beginning of a word, saturated, and what follows it.
fn split_integer(word: &[u8]) -> (Option<i64>, &[u8]) {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    let length = digits.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if length == 0 {
        return (None, word);
    }
    let add = |value: i64, &digit: &u8| value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
    let value = digits[..length].iter().fold(0, add);
    (Some(if negative { -value } else { value }), &digits[length..])
}
