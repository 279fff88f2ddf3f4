//! Wavefront OBJ, read by `tobj`: positions, texture coordinates, normals and faces. Other lines are skipped. Grouping
//! is skipped too, so smooth normals continue across objects, as in Mitsuba.
//!
//! `tobj` reads some lines differently from Mitsuba, or misreads them without an error. Such lines are rewritten before
//! `tobj` sees them, or refused.

use std::io::{self, BufRead, Read, Write};
use std::path::Path;

use glam::Vec3;

use super::triangles::{Cutter, MAX_TRIANGLES, Mesh};
use super::words::Words;
use crate::{Error, Result, quoted};

/// Reads the mesh in the OBJ file at `path`, which holds `text`.
pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Mesh> {
    if let Ok(mesh) = Lines::new(text, None).mesh() {
        return Ok(mesh);
    }
    // The second pass knows the totals and checks each line, so that the error names the faulty line.
    let mut lines = Lines::new(text, Some(totals(text)));
    lines.mesh().map_err(|message| Error::scene(path, Some(lines.line), message))
}

/// Numbers of positions, texture coordinates and normals in the file.
type Totals = [usize; 3];
const KEYWORDS: [&str; 3] = ["v", "vt", "vn"];
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];
/// Components of each kind.
const SIZES: [usize; 3] = [3, 2, 3];

/// Length in bytes up to which a line of numbers without exponents has only finite numbers.
const FINITE_BYTES: usize = 38;
/// Length in bytes up to which the indices of a corner are far from overflow.
const CORNER_BYTES: usize = 18;

/// Indices into positions, texture coordinates and normals, counted from 1.
type Corner = [Option<usize>; 3];

/// Kinds of lines, by their first word.
enum Keyword {
    /// Numbers of the kind with this index in [`KEYWORDS`].
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

/// Lines of a mesh as `tobj` gets them. Plain lines are passed on as they are; any other line is checked and rewritten.
struct Lines<'a> {
    rest: &'a [u8],
    /// The current line, counted from 1.
    line: u32,
    /// Rest of the plain lines that `tobj` has not taken yet.
    plain: &'a [u8],
    /// Rewritten line, of which `tobj` has taken the first `taken` bytes.
    rewritten: Vec<u8>,
    taken: usize,
    /// Positions, texture coordinates and normals read so far.
    counts: Totals,
    faces: usize,
    /// Number of faces that are points or lines.
    left_out: usize,
    /// Whether corners of rewritten faces have an index of each kind.
    has: [bool; 3],
    /// Totals of the file, for the second pass only. Then no line counts as plain, and a corner without an index gets
    /// one past the last, which refers to an appended zero.
    totals: Option<Totals>,
    polygon: Vec<Corner>,
    fault: Option<String>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a [u8], totals: Option<Totals>) -> Self {
        Self {
            rest: text,
            line: 0,
            plain: &[],
            rewritten: Vec::new(),
            taken: 0,
            counts: [0; 3],
            faces: 0,
            left_out: 0,
            has: [false; 3],
            totals,
            polygon: Vec::new(),
            fault: None,
        }
    }

    /// Reads the mesh of all lines. An error is about the current line.
    fn mesh(&mut self) -> Result<Mesh, String> {
        let options = tobj::LoadOptions { single_index: true, ..Default::default() };
        let read = tobj::load_obj_buf(self, &options, |_| Ok(Default::default()));
        let (models, _) = read.map_err(|error| self.fault.take().unwrap_or_else(|| error.to_string()))?;
        // There is one model, because names of objects and materials were skipped.
        let mesh = models.into_iter().next().ok_or("there is no mesh")?.mesh;
        let positions: Vec<Vec3> = bytemuck::cast_slice(&mesh.positions).to_vec();
        let (triangles, left_out) = triangles(&mesh, &positions)?;
        Ok(Mesh {
            uvs: bytemuck::cast_slice(self.complete(1, &mesh.texcoords, &mesh)?).to_vec(),
            normals: bytemuck::cast_slice(self.complete(2, &mesh.normals, &mesh)?).to_vec(),
            triangles,
            positions,
            left_out: left_out + self.left_out,
            ..Mesh::default()
        })
    }

    /// Returns the `numbers` of a kind if every vertex has them, and nothing if no vertex has. If only some have, it is
    /// an error: `tobj` leaves gaps out, so later numbers would belong to wrong vertices.
    fn complete<'b>(&self, kind: usize, numbers: &'b [f32], mesh: &tobj::Mesh) -> Result<&'b [f32], String> {
        let is_complete = numbers.len() / SIZES[kind] == mesh.positions.len() / SIZES[0];
        match self.totals {
            Some(_) if !self.has[kind] => Ok(&[]),
            _ if is_complete => Ok(numbers),
            None if numbers.is_empty() && !(self.has[kind] && self.counts[kind] == 0) => Ok(&[]),
            _ => Err(format!("some vertices lack a {}", KINDS[kind])),
        }
    }

    /// Prepares the next lines for `tobj`; at the end of the file there are none.
    fn advance(&mut self) -> Result<(), String> {
        self.rewritten.clear();
        self.taken = 0;
        if self.totals.is_none() {
            self.plain = self.plain_lines()?;
        }
        while self.plain.is_empty() && self.rewritten.is_empty() && !self.rest.is_empty() {
            let (line, rest) = split_line(self.rest);
            self.rest = rest;
            self.line = self.line.saturating_add(1);
            self.rewrite(line)?;
            if rest.is_empty() && self.totals.is_some() {
                self.rewritten.extend(b"vt 0 0\nvn 0 0 0\n");
            }
        }
        Ok(())
    }

    /// Takes the plain lines that come next.
    fn plain_lines(&mut self) -> Result<&'a [u8], String> {
        let text = self.rest;
        while !self.rest.is_empty() {
            let (line, rest) = split_line(self.rest);
            let Some(keyword) = self.plain_keyword(line) else { break };
            self.count(&keyword)?;
            self.rest = rest;
            self.line = self.line.saturating_add(1);
        }
        Ok(&text[..text.len() - self.rest.len()])
    }

    fn count(&mut self, keyword: &Keyword) -> Result<(), String> {
        match *keyword {
            Keyword::Numbers(kind) => self.counts[kind] += 1,
            Keyword::Face => self.faces += 1,
            Keyword::Other => {}
        }
        if self.faces > MAX_TRIANGLES {
            return Err(format!("no more than {MAX_TRIANGLES} faces fit"));
        }
        Ok(())
    }

    fn rewrite(&mut self, line: &[u8]) -> Result<(), String> {
        let mut words = Words::new(line);
        let keyword = Keyword::of(&mut words);
        self.count(&keyword)?;
        match keyword {
            Keyword::Numbers(kind) => self.rewrite_numbers(kind, &mut words),
            Keyword::Face => self.rewrite_face(&mut words),
            Keyword::Other => Ok(()),
        }
    }

    /// Keyword of a line that `tobj` reads as Mitsuba does, or refuses; `None` for any other line.
    fn plain_keyword(&self, line: &[u8]) -> Option<Keyword> {
        let line = line.trim_ascii_end();
        if let Some(corners) = line.strip_prefix(b"f ") {
            // Where the file has no texture coordinates or normals so far, `tobj` ignores their indices unchecked.
            let is_plain = self.counts[1] > 0 && self.counts[2] > 0 && is_plain_face(corners);
            return is_plain.then_some(Keyword::Face);
        }
        let (kind, numbers) = match line {
            [b'v', b' ', numbers @ ..] => (0, numbers),
            [b'v', b't', b' ', numbers @ ..] => (1, numbers),
            [b'v', b'n', b' ', numbers @ ..] => (2, numbers),
            _ => return None,
        };
        are_plain_numbers(numbers, (kind == 0).then_some(SIZES[0])).then_some(Keyword::Numbers(kind))
    }

    fn rewrite_numbers(&mut self, kind: usize, words: &mut Words) -> Result<(), String> {
        self.rewritten.extend(KEYWORDS[kind].as_bytes());
        if SIZES[kind] == 3 {
            self.write_numbers(words.floats::<3>()?)
        } else {
            self.write_numbers(words.floats::<2>()?)
        }
    }

    fn write_numbers<const N: usize>(&mut self, numbers: [f32; N]) -> Result<(), String> {
        for number in numbers {
            write!(self.rewritten, " {number:e}").map_err(|error| error.to_string())?;
        }
        self.rewritten.push(b'\n');
        Ok(())
    }

    fn rewrite_face(&mut self, words: &mut Words) -> Result<(), String> {
        self.polygon.clear();
        loop {
            match words.next() {
                [] | [b'#', ..] => break,
                word => {
                    let corner = self.corner(word)?;
                    self.polygon.push(corner);
                }
            }
        }
        if self.polygon.len() < 3 {
            self.left_out += 1;
            return Ok(());
        }
        self.rewritten.push(b'f');
        for corner in &self.polygon {
            for (kind, index) in corner.iter().enumerate() {
                self.has[kind] |= index.is_some();
                self.rewritten.push(if kind == 0 { b' ' } else { b'/' });
                if let Some(index) = index.or(self.totals.map(|totals| totals[kind] + 1)) {
                    write!(self.rewritten, "{index}").map_err(|error| error.to_string())?;
                }
            }
        }
        self.rewritten.push(b'\n');
        Ok(())
    }

    /// Parses a corner: `position`, `position/uv`, `position//normal` or `position/uv/normal`.
    fn corner(&self, word: &[u8]) -> Result<Corner, String> {
        let word = String::from_utf8_lossy(word);
        let mut corner = [None; 3];
        for (kind, index) in word.split('/').enumerate() {
            if kind == 3 {
                return Err(format!("{} has too many indices", quoted::word(&word)));
            }
            if kind == 0 || !index.is_empty() {
                corner[kind] = Some(self.index(kind, index).ok_or_else(|| self.not_an_index(kind, index, &word))?);
            }
        }
        Ok(corner)
    }

    /// Parses an index that counts from 1, or if negative back from the last one read. Returns it counted from 1.
    fn index(&self, kind: usize, index: &str) -> Option<usize> {
        let limit = self.totals.map_or(u32::MAX as usize, |totals| totals[kind]);
        let distance: isize = index.parse().ok()?;
        let index = if distance < 0 { self.counts[kind] + 1 } else { 0 }.checked_add_signed(distance)?;
        (index != 0 && index <= limit).then_some(index)
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

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.plain.is_empty() && self.taken == self.rewritten.len() {
            self.advance().map_err(|fault| {
                self.fault = Some(fault);
                io::ErrorKind::InvalidData
            })?;
        }
        Ok(if self.plain.is_empty() { &self.rewritten[self.taken..] } else { self.plain })
    }

    fn consume(&mut self, count: usize) {
        if self.plain.is_empty() {
            self.taken += count;
        } else {
            self.plain = &self.plain[count..];
        }
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

/// Splits the first line, with its line break, from a text.
fn split_line(text: &[u8]) -> (&[u8], &[u8]) {
    let mut rest = text;
    // Reading memory cannot fail. This finds line breaks many bytes at a time.
    let length = rest.skip_until(b'\n').unwrap_or_default();
    text.split_at(length)
}

/// Whether numbers are separated by spaces, have no exponents, and are so short that all are finite. `count` says how many
/// there must be, with single spaces between them: `tobj` divides three numbers by a fourth and takes six for a color. In
/// other lines it ignores more numbers.
fn are_plain_numbers(numbers: &[u8], count: Option<usize>) -> bool {
    if numbers.len() > FINITE_BYTES {
        return false;
    }
    let (mut blanks, mut are_plain) = (0_u8, true);
    for &byte in numbers {
        blanks += u8::from(byte == b' ');
        are_plain &= byte == b' ' || (b'-'..=b'9').contains(&byte);
    }
    are_plain && count.is_none_or(|count| usize::from(blanks) + 1 == count)
}

/// Whether corners are separated by single spaces, and have up to three indices that are absent or at least 1.
fn is_plain_face(corners: &[u8]) -> bool {
    let (mut length, mut slashes, mut before) = (0, 0, b' ');
    for &byte in corners {
        match byte {
            b' ' => (length, slashes) = (0, 0),
            b'/' => slashes += 1,
            b'1'..=b'9' => {}
            b'0' if before.is_ascii_digit() => {}
            _ => return false,
        }
        length += 1;
        if length > CORNER_BYTES || slashes > 2 {
            return false;
        }
        before = byte;
    }
    true
}

/// Triangles of a mesh, and the number of faces that are none.
fn triangles(mesh: &tobj::Mesh, positions: &[Vec3]) -> Result<(Vec<[u32; 3]>, usize), String> {
    if mesh.face_arities.is_empty() {
        return Ok((bytemuck::cast_slice(&mesh.indices).to_vec(), 0));
    }
    let (mut triangles, mut cutter) = (Vec::with_capacity(mesh.face_arities.len()), Cutter::default());
    let mut rest = &mesh.indices[..];
    for &arity in &mesh.face_arities {
        let (polygon, others) = rest.split_at(arity as usize);
        cutter.add(&mut triangles, polygon, positions)?;
        rest = others;
    }
    Ok((triangles, cutter.left_out))
}
