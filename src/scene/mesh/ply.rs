//! Polygon files (PLY), as text or binary of either byte order. Unneeded properties are skipped. Counts in the file are
//! not trusted: memory grows only with the data that arrives.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::ply_attributes::Kept;
use super::triangles::{Cutter, MAX_TRIANGLES, Mesh};
use super::words::Words;
use crate::{Error, Result, quoted};

/// Bytes in which a header is looked for without reading the file.
const MOST_HEADER_BYTES: u64 = 1 << 16;

/// Reads the mesh in the PLY file at `path`, which holds `bytes`, with those of the `attributes` that it has.
pub(super) fn parse(path: &Path, bytes: &[u8], attributes: &[&str]) -> Result<Mesh> {
    let fault = |(line, message): (Option<u32>, String)| Error::scene(path, line, message);
    let (header, source) = read_header(bytes).map_err(fault)?;
    read_body(&header, source, attributes).map_err(fault)
}

/// Number of faces that the header of a file promises; `None` where it is no header of usual length, and where the file alone has more
/// than fit, which [`parse`] tells.
pub(super) fn promised_faces(file: impl Read) -> Option<u64> {
    let mut beginning = Vec::new();
    file.take(MOST_HEADER_BYTES).read_to_end(&mut beginning).ok()?;
    let (elements, _) = read_header(&beginning).ok()?;
    let faces = elements.iter().find(|element| element.name == "face")?.count;
    (faces <= MAX_TRIANGLES as u64).then_some(faces)
}

/// Line of the fault (for text files) and message.
type Fault = (Option<u32>, String);

#[derive(Clone, Copy)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// Number types of PLY properties.
#[derive(Clone, Copy, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

struct Property {
    name: String,
    scalar: Scalar,
    /// Number type of a list's length; `None` where the property is no list.
    length: Option<Scalar>,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

fn read_header(bytes: &[u8]) -> Result<(Vec<Element>, Source<'_>), Fault> {
    let mut words = Words::new(bytes);
    if words.next() != b"ply" {
        return Err((None, "this is not a PLY file: it does not begin with `ply`".to_string()));
    }
    let (mut encoding, mut elements) = (None, Vec::new());
    while words.next_line() {
        let line = words.line();
        let fault = |message| (Some(line), message);
        match words.next() {
            b"format" => encoding = Some(read_format(&mut words).map_err(fault)?),
            b"element" => {
                let element = read_element(&mut words).map_err(fault)?;
                let is_known = |own: &Element| own.name == element.name;
                if matches!(&*element.name, "vertex" | "face") && elements.iter().any(is_known) {
                    return Err(fault(format!("a second element `{}`; a mesh has one", element.name)));
                }
                elements.push(element);
            }
            b"property" => {
                let property = read_property(&mut words).map_err(fault)?;
                let owner: &mut Element =
                    elements.last_mut().ok_or_else(|| fault("a property without an element".to_string()))?;
                owner.properties.push(property);
            }
            b"end_header" => {
                words.next_line();
                let encoding = encoding.ok_or_else(|| fault("the header names no format".to_string()))?;
                return Ok((elements, Source { encoding, words }));
            }
            [] | b"comment" | b"obj_info" => {}
            word => return Err(fault(format!("{} is not a keyword of PLY headers", quoted::bytes(word)))),
        }
    }
    Err((Some(words.line()), "the header does not end: is the file cut short?".to_string()))
}

fn read_format(words: &mut Words) -> Result<Encoding, String> {
    match words.next() {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        word => Err(format!("the PLY format {} is not supported", quoted::bytes(word))),
    }
}

fn read_element(words: &mut Words) -> Result<Element, String> {
    let (name, count) = (text(words.next()), text(words.next()));
    let count = count.parse().map_err(|_| format!("{} is not a number of elements", quoted::word(&count)))?;
    Ok(Element { name, count, properties: Vec::new() })
}

fn read_property(words: &mut Words) -> Result<Property, String> {
    let first = words.next();
    let (length, scalar) = match first {
        b"list" => (Some(scalar(words.next())?), scalar(words.next())?),
        _ => (None, scalar(first)?),
    };
    Ok(Property { name: text(words.next()), scalar, length })
}

fn scalar(word: &[u8]) -> Result<Scalar, String> {
    Ok(match word {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return Err(format!("{} is not a type of a PLY property", quoted::bytes(word))),
    })
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}

/// Content of the file after the header.
struct Source<'a> {
    encoding: Encoding,
    words: Words<'a>,
}

impl Source<'_> {
    /// Reads the next number; `None` where the file ends.
    fn number(&mut self, scalar: Scalar) -> Result<Option<f64>, String> {
        match self.encoding {
            Encoding::Text => self.word(),
            Encoding::LittleEndian => Ok(self.binary(scalar, false)),
            Encoding::BigEndian => Ok(self.binary(scalar, true)),
        }
    }

    fn word(&mut self) -> Result<Option<f64>, String> {
        loop {
            let word = self.words.next();
            if !word.is_empty() {
                let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
                return number.map(Some).ok_or_else(|| format!("{} is not a number", quoted::bytes(word)));
            }
            if !self.words.next_line() {
                return Ok(None);
            }
        }
    }

    fn binary(&mut self, scalar: Scalar, is_big_endian: bool) -> Option<f64> {
        let bytes = self.words.bytes(scalar.size())?;
        let mut b = [0; 8];
        b[..bytes.len()].copy_from_slice(bytes);
        if is_big_endian {
            b[..bytes.len()].reverse();
        }
        Some(match scalar {
            Scalar::I8 => f64::from(b[0] as i8),
            Scalar::U8 => f64::from(b[0]),
            Scalar::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Scalar::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Scalar::I32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Scalar::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Scalar::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Scalar::F64 => f64::from_le_bytes(b),
        })
    }

    /// Current line of a text file; `None` for a binary one.
    fn line(&self) -> Option<u32> {
        matches!(self.encoding, Encoding::Text).then(|| self.words.line())
    }
}

impl Scalar {
    /// Number that stands for a color of 1.
    fn largest_color(self) -> f32 {
        match self {
            Self::I8 => f32::from(i8::MAX),
            Self::U8 => f32::from(u8::MAX),
            Self::I16 => f32::from(i16::MAX),
            Self::U16 => f32::from(u16::MAX),
            Self::I32 => i32::MAX as f32,
            Self::U32 => u32::MAX as f32,
            Self::F32 | Self::F64 => 1.0,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Property names of the numbers that are kept for a vertex; a number may have several names.
const VERTEX_NUMBERS: [&[&str]; 11] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
    &["r", "red"],
    &["g", "green"],
    &["b", "blue"],
];

/// Place of the first coordinate of the normal in [`VERTEX_NUMBERS`].
const FIRST_NORMAL: usize = 3;
/// Place of the first color in [`VERTEX_NUMBERS`].
const FIRST_COLOR: usize = 8;

fn read_body(elements: &[Element], mut source: Source, attributes: &[&str]) -> Result<Mesh, Fault> {
    let mut mesh = Mesh::default();
    for element in elements {
        read_items(element, &mut source, &mut mesh, attributes).map_err(|message| (source.line(), message))?;
    }
    Ok(mesh)
}

fn read_items(element: &Element, source: &mut Source, mesh: &mut Mesh, attributes: &[&str]) -> Result<(), String> {
    match element.name.as_str() {
        "vertex" => read_vertices(element, source, mesh, attributes),
        "face" => read_faces(element, source, mesh, attributes),
        // Items without properties take no space in the file, so they are not counted through.
        _ if element.properties.is_empty() => Ok(()),
        _ => (0..element.count).try_for_each(|_| element.read(source, |_, _| Ok(()))),
    }
}

impl Element {
    /// Reads one item. `keep` is called with each number and its property's index; a list gives its numbers one by one.
    fn read(&self, source: &mut Source, mut keep: impl FnMut(usize, f64) -> Result<(), String>) -> Result<(), String> {
        for (place, property) in self.properties.iter().enumerate() {
            let length = match property.length {
                Some(length) => whole(self.number(source, length)?, "the length of a list")?,
                None => 1,
            };
            for _ in 0..length {
                keep(place, self.number(source, property.scalar)?)?;
            }
        }
        Ok(())
    }

    fn number(&self, source: &mut Source, scalar: Scalar) -> Result<f64, String> {
        source.number(scalar)?.ok_or_else(|| {
            format!(
                "the file ends too early: its header promises {} of the element {}",
                self.count,
                quoted::word(&self.name)
            )
        })
    }

    /// Attributes of the items that textures may show. `kind` is the beginning of their names.
    fn attributes(&self, kind: &str, wanted: &[&str]) -> Kept {
        Kept::of(kind, &self.names(), wanted)
    }

    /// Names of the properties; `None` stands for a list.
    fn names(&self) -> Vec<Option<&str>> {
        self.properties.iter().map(|property| property.length.is_none().then_some(&*property.name)).collect()
    }

    /// Index of the property that has one of these names and is a list or not.
    fn place(&self, names: &[&str], is_list: bool) -> Option<usize> {
        let is_it = |p: &Property| names.contains(&p.name.as_str()) && p.length.is_some() == is_list;
        self.properties.iter().position(is_it)
    }
}

fn whole(number: f64, what: &str) -> Result<u32, String> {
    if (0.0..=f64::from(u32::MAX)).contains(&number) && number.fract() == 0.0 {
        return Ok(number as u32);
    }
    Err(format!("{number} is not {what}"))
}

fn read_vertices(element: &Element, source: &mut Source, mesh: &mut Mesh, wanted: &[&str]) -> Result<(), String> {
    let places = VERTEX_NUMBERS.map(|names| element.place(names, false));
    let has = |range: std::ops::Range<usize>| places[range].iter().all(Option::is_some);
    if !has(0..3) {
        return Err("the element `vertex` lacks x, y or z".to_string());
    }
    let (has_normals, has_uvs, has_colors) = (has(3..6), has(6..8), has(FIRST_COLOR..11));
    let largest = |place: Option<usize>| place.map_or(1.0, |place| element.properties[place].scalar.largest_color());
    let largest = [8, 9, 10].map(|own| largest(places[own]));
    mesh.has_byte_colors |= has_colors && largest.iter().any(|&largest| largest != 1.0);
    let mut attributes = element.attributes("vertex_", wanted);
    if !wanted.is_empty() {
        attributes.check_sets(&element.names())?;
    }
    for _ in 0..element.count {
        let mut vertex = [0.0_f32; VERTEX_NUMBERS.len()];
        element.read(source, |place, number| {
            if let Some(at) = places.iter().position(|&own| own == Some(place)) {
                // Colors that nobody uses may be anything, and some exporters write normals that are no numbers.
                let is_free = (FIRST_NORMAL..FIRST_NORMAL + 3).contains(&at) || at >= FIRST_COLOR;
                vertex[at] = if is_free { number as f32 } else { finite(number)? };
            }
            attributes.note(place, number);
            Ok(())
        })?;
        attributes.push(1);
        let [x, y, z, nx, ny, nz, u, v, red, green, blue] = vertex;
        mesh.positions.push(Vec3::new(x, y, z));
        if has_normals {
            let normal = Vec3::new(nx, ny, nz);
            mesh.normals.push(if normal.is_finite() { normal } else { Vec3::ZERO });
        }
        if has_uvs {
            mesh.uvs.push(Vec2::new(u, v));
        }
        if has_colors {
            mesh.colors.push(Vec3::new(red, green, blue) / Vec3::from_array(largest));
        }
    }
    mesh.attributes.extend(attributes.finish());
    Ok(())
}

fn finite(number: f64) -> Result<f32, String> {
    Some(number as f32).filter(|number| number.is_finite()).ok_or_else(|| format!("`{number}` is not a finite number"))
}

fn read_faces(element: &Element, source: &mut Source, mesh: &mut Mesh, wanted: &[&str]) -> Result<(), String> {
    if element.count > MAX_TRIANGLES as u64 {
        let count = element.count;
        return Err(format!("the header promises {count} faces; no more than {MAX_TRIANGLES} fit a scene"));
    }
    let place = element.place(&["vertex_indices", "vertex_index"], true);
    let place = place.ok_or("the element `face` lacks its list `vertex_indices`")?;
    let wedges = element.place(&["texcoord"], true);
    let vertex_count = mesh.positions.len();
    let (mut polygon, mut uvs, mut cutter) = (Vec::new(), Vec::new(), Cutter::default());
    let mut seams = Seams::new(vertex_count);
    let mut attributes = element.attributes("face_", wanted);
    for _ in 0..element.count {
        polygon.clear();
        uvs.clear();
        element.read(source, |own, number| {
            if own == place {
                let index = whole(number, "the index of a vertex")?;
                if index as usize >= vertex_count {
                    return Err(format!("vertex index {index} is out of range; {vertex_count} come before the faces"));
                }
                polygon.push(index);
            } else if Some(own) == wedges {
                uvs.push(finite(number)?);
            }
            attributes.note(own, number);
            Ok(())
        })?;
        if wedges.is_some() {
            seams.split(&mut polygon, &uvs, mesh)?;
        }
        let before = mesh.triangles.len();
        cutter.add(&mut mesh.triangles, &polygon, &mesh.positions)?;
        attributes.push(mesh.triangles.len() - before);
    }
    mesh.attributes.extend(attributes.finish());
    mesh.left_out += cutter.left_out;
    if !mesh.uvs.is_empty() {
        mesh.uvs.resize(mesh.positions.len(), Vec2::ZERO);
    }
    Ok(())
}

/// Vertices of a mesh whose faces give the texture coordinates of their corners. A vertex whose faces disagree is kept once for each
/// coordinate, so that textures have seams there.
struct Seams {
    /// Index of the vertex with a texture coordinate, by the file's vertex and the bits of the coordinate.
    known: HashMap<(u32, [u32; 2]), u32>,
    /// Whether the vertices of the file have a coordinate already.
    is_taken: Vec<bool>,
}

impl Seams {
    fn new(vertex_count: usize) -> Self {
        Self { known: HashMap::new(), is_taken: vec![false; vertex_count] }
    }

    /// Replaces the vertices of a polygon by those with its texture coordinates.
    fn split(&mut self, polygon: &mut [u32], uvs: &[f32], mesh: &mut Mesh) -> Result<(), String> {
        let (uvs, rest) = uvs.as_chunks::<2>();
        // A face without a texture gives none.
        if uvs.is_empty() && rest.is_empty() {
            return Ok(());
        }
        if uvs.len() != polygon.len() || !rest.is_empty() {
            let (numbers, corners) = (2 * uvs.len() + rest.len(), polygon.len());
            return Err(format!(
                "`texcoord` has {numbers} numbers for a face of {corners} corners; it needs two for each"
            ));
        }
        mesh.uvs.resize(mesh.positions.len(), Vec2::ZERO);
        for (index, &uv) in polygon.iter_mut().zip(uvs) {
            let key = (*index, uv.map(f32::to_bits));
            *index = match self.known.get(&key) {
                Some(&known) => known,
                None => {
                    let own = self.add(*index as usize, Vec2::from_array(uv), mesh);
                    self.known.insert(key, own);
                    own
                }
            };
        }
        Ok(())
    }

    /// Vertex of the file, or a copy of it where it has another texture coordinate.
    fn add(&mut self, vertex: usize, uv: Vec2, mesh: &mut Mesh) -> u32 {
        if !std::mem::replace(&mut self.is_taken[vertex], true) {
            mesh.uvs[vertex] = uv;
            return vertex as u32;
        }
        mesh.positions.push(mesh.positions[vertex]);
        mesh.normals.extend(mesh.normals.get(vertex).copied());
        mesh.colors.extend(mesh.colors.get(vertex).copied());
        mesh.attributes.iter_mut().for_each(|own| own.values.extend(own.values.get(vertex).copied()));
        mesh.uvs.push(uv);
        mesh.positions.len() as u32 - 1
    }
}
