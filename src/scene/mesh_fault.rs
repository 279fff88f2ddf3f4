//! The line of an OBJ file that is at fault: `tobj` says what is wrong, but not where.

use std::path::Path;

use crate::Error;

/// The error for a mesh file that could not be read; `reason` is used where the scan below finds nothing.
pub(super) fn explain(path: &Path, text: &[u8], reason: &str) -> Error {
    match first_fault(text) {
        Some((line, message)) => Error::scene(path, Some(line), message),
        None => Error::scene(path, None, reason),
    }
}

/// Whether a face has fewer than three vertices, which is how a file cut short tends to end.
pub(super) fn has_short_face(text: &[u8]) -> bool {
    lines(text).any(|line| {
        let mut words = words(line);
        words.next() == Some(b"f") && words.take(3).count() < 3
    })
}

/// How many of each a face may refer to.
#[derive(Default)]
struct Counts {
    positions: i64,
    uvs: i64,
    normals: i64,
}

/// A face may refer to what stands below it, so the counts are those of the whole file; relative indices count from
/// where the face stands.
fn first_fault(text: &[u8]) -> Option<(u32, String)> {
    let mut total = Counts::default();
    lines(text).for_each(|line| total.add(line));
    let mut here = Counts::default();
    lines(text).zip(1..).find_map(|(line, number)| {
        here.add(line);
        Some((number, fault_in(line, &here, &total)?))
    })
}

fn fault_in(line: &[u8], here: &Counts, total: &Counts) -> Option<String> {
    let text = String::from_utf8_lossy(line);
    let mut words = text.split_whitespace();
    let count = match words.next()? {
        "v" | "vn" => 3,
        "vt" => 2,
        "f" => return face_fault(&words.collect::<Vec<_>>(), here, total),
        _ => return None,
    };
    let numbers: Vec<_> = words.take(count).collect();
    if numbers.len() < count {
        return Some(format!("`{}` should have {count} numbers", text.trim()));
    }
    let bad = numbers.into_iter().find(|word| !word.parse::<f32>().is_ok_and(f32::is_finite))?;
    Some(format!("`{bad}` is not a finite number"))
}

fn face_fault(vertices: &[&str], here: &Counts, total: &Counts) -> Option<String> {
    if vertices.len() < 3 {
        return Some("a face needs at least three vertices".to_string());
    }
    vertices.iter().find_map(|vertex| {
        let kinds = [
            ("vertex", here.positions, total.positions),
            ("texture coordinate", here.uvs, total.uvs),
            ("normal", here.normals, total.normals),
        ];
        if vertex.split('/').count() > kinds.len() {
            return Some(format!("`{vertex}` has too many indices"));
        }
        let mut indices = vertex.split('/').zip(kinds).enumerate();
        indices.find_map(|(i, (index, (kind, here, total)))| match index.parse::<i64>() {
            Err(_) if index.is_empty() && i > 0 => None,
            Err(_) => Some(format!("`{vertex}` is not a vertex of a face")),
            Ok(index) if (1..=total).contains(&index) || (-here..0).contains(&index) => None,
            Ok(index) => Some(format!("{kind} index {index} is out of range; the file has {total}")),
        })
    })
}

impl Counts {
    fn add(&mut self, line: &[u8]) {
        match words(line).next() {
            Some(b"v") => self.positions += 1,
            Some(b"vt") => self.uvs += 1,
            Some(b"vn") => self.normals += 1,
            _ => {}
        }
    }
}

fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|&byte| byte == b'\n')
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}
