//! Decoders of indices: the modes `TRIANGLES` and `INDICES` of `EXT_meshopt_compression` and `KHR_meshopt_compression`.

use super::reader::{Fault, Reader, signed};

/// Entries of a queue that lie farther back are forgotten.
const QUEUE: usize = 16;

/// The entries that were added last.
struct Queue<T> {
    entries: [T; QUEUE],
    next: usize,
}

impl<T: Copy> Queue<T> {
    fn new(entry: T) -> Self {
        Self { entries: [entry; QUEUE], next: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.next] = entry;
        self.next = (self.next + 1) % QUEUE;
    }

    /// The entry that was added `age` entries before the last one.
    fn get(&self, age: u8) -> T {
        self.entries[(self.next + 2 * QUEUE - 1 - usize::from(age)) % QUEUE]
    }
}

/// Decoder of triangles.
struct Triangles<'a> {
    codes: Reader<'a>,
    data: Reader<'a>,
    /// Ages of vertices that triangles often have.
    ages: &'a [u8],
    /// Index of the next new vertex.
    next: u32,
    /// Index that was given last.
    last: u32,
    edges: Queue<[u32; 2]>,
    vertices: Queue<u32>,
}

/// Bytes of the table of ages.
const AGES: usize = 16;

/// `count` indices of triangles, of `stride` bytes each: 2 or 4.
pub(super) fn triangles(source: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Fault> {
    let rest = source.strip_prefix(&[0xe1]).ok_or(Fault::Head)?;
    let (rest, ages) = rest.split_at_checked(rest.len().saturating_sub(AGES)).ok_or(Fault::Short)?;
    let (codes, data) = rest.split_at_checked(count / 3).ok_or(Fault::Short)?;
    if ages.len() < AGES {
        return Err(Fault::Short);
    }
    let mut decoder = Triangles {
        codes: Reader::new(codes),
        data: Reader::new(data),
        ages,
        next: 0,
        last: 0,
        // An edge or a vertex that nobody has added makes a triangle that no mesh has.
        edges: Queue::new([u32::MAX; 2]),
        vertices: Queue::new(u32::MAX),
    };
    let mut bytes = Vec::with_capacity(count * stride);
    while !decoder.codes.is_at_end() {
        let triangle = decoder.triangle()?;
        triangle.into_iter().for_each(|index| push(&mut bytes, index, stride));
    }
    if decoder.data.is_at_end() { Ok(bytes) } else { Err(Fault::Long) }
}

impl Triangles<'_> {
    fn triangle(&mut self) -> Result<[u32; 3], Fault> {
        let code = self.codes.byte()?;
        let (edge, vertex) = (code >> 4, code & 15);
        if edge < 15 {
            let [a, b] = self.edges.get(edge);
            let c = match vertex {
                0 => self.new_vertex(),
                1..=12 => self.vertices.get(vertex),
                13 => self.neighbor(u32::MAX),
                14 => self.neighbor(1),
                _ => self.given()?,
            };
            if !(1..=12).contains(&vertex) {
                self.vertices.push(c);
            }
            self.edges.push([c, b]);
            self.edges.push([a, c]);
            return Ok([a, b, c]);
        }
        let ages = match vertex {
            14 | 15 => self.data.byte()?,
            vertex => self.ages[usize::from(vertex)],
        };
        let is_explicit = vertex >= 14;
        if is_explicit && ages == 0 {
            self.next = 0;
        }
        let a = if vertex == 15 { self.given()? } else { self.new_vertex() };
        let (b, is_new_b) = self.by_age(ages >> 4, is_explicit)?;
        let (c, is_new_c) = self.by_age(ages & 15, is_explicit)?;
        self.vertices.push(a);
        if is_new_b {
            self.vertices.push(b);
        }
        if is_new_c {
            self.vertices.push(c);
        }
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// Vertex of an age, and whether it is not in the queue.
    fn by_age(&mut self, age: u8, is_explicit: bool) -> Result<(u32, bool), Fault> {
        Ok(match age {
            0 => (self.new_vertex(), true),
            15 if is_explicit => (self.given()?, true),
            15 => return Err(Fault::Code),
            age => (self.vertices.get(age - 1), false),
        })
    }

    fn new_vertex(&mut self) -> u32 {
        let vertex = self.next;
        self.next = vertex.wrapping_add(1);
        vertex
    }

    fn neighbor(&mut self, step: u32) -> u32 {
        self.last = self.last.wrapping_add(step);
        self.last
    }

    /// Vertex whose index is given by its difference to the one given before.
    fn given(&mut self) -> Result<u32, Fault> {
        let number = self.data.number()?;
        Ok(self.neighbor(signed(number)))
    }
}

/// Bytes at the end of a sequence of indices.
const SEQUENCE_END: usize = 4;

/// `count` indices in any order, of `stride` bytes each: 2 or 4.
pub(super) fn sequence(source: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Fault> {
    let rest = source.strip_prefix(&[0xd1]).ok_or(Fault::Head)?;
    let length = rest.len().checked_sub(SEQUENCE_END).filter(|length| *length >= count).ok_or(Fault::Short)?;
    let mut reader = Reader::new(&rest[..length]);
    let mut bytes = Vec::with_capacity(count * stride);
    // Two sequences may take turns.
    let mut last = [0_u32; 2];
    for _ in 0..count {
        let number = reader.number()?;
        let last = &mut last[(number & 1) as usize];
        *last = last.wrapping_add(signed(number >> 1));
        push(&mut bytes, *last, stride);
    }
    if reader.is_at_end() { Ok(bytes) } else { Err(Fault::Long) }
}

fn push(bytes: &mut Vec<u8>, index: u32, stride: usize) {
    bytes.extend_from_slice(&index.to_le_bytes()[..stride]);
}
