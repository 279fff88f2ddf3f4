//! Reader of accessors: rows of numbers in buffers. Every access is checked against the buffer's end.

use gltf::Accessor;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};

use super::document::Model;
use crate::Result;

/// Most values of an accessor: three for each corner of the largest mesh.
const MAX_VALUES: usize = 1 << 28;

/// Rows of an accessor as numbers, with integers mapped to 0..1 or -1..1 where the accessor is normalized.
pub(super) struct Rows {
    /// Numbers in a row.
    pub columns: usize,
    pub values: Vec<f64>,
}

/// Reads an accessor.
pub(super) fn rows(model: &Model, accessor: &Accessor, what: &str) -> Result<Rows> {
    let fault = |message: &str| model.error(what, format!("accessor {}: {message}", accessor.index()));
    let columns = match accessor.dimensions() {
        Dimensions::Scalar => 1,
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        Dimensions::Vec4 => 4,
        Dimensions::Mat4 => 16,
        _ => return Err(fault("matrices of this size are not supported")),
    };
    let count = accessor.count();
    let total = count.checked_mul(columns).filter(|&total| total <= MAX_VALUES);
    let total = total.ok_or_else(|| fault("it has too many values"))?;
    let kind = accessor.data_type();
    let number = |bytes: &[u8]| value(bytes, kind, accessor.normalized());
    let mut values = match accessor.view() {
        Some(view) => {
            let stride = view.stride().unwrap_or(columns * kind.size());
            let bytes = content(model, &view, accessor.offset()).ok_or_else(|| fault("it reaches beyond its buffer"))?;
            read(bytes, count, columns, stride, kind.size(), number).ok_or_else(|| fault("it reaches beyond its view"))?
        }
        // Without a view, all values are 0 until sparse ones replace them.
        None if accessor.sparse().is_some() => vec![0.0; total],
        None => return Err(fault("it has no content; compressed meshes are not supported")),
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, replacements) = (sparse.indices(), sparse.values());
        let index_kind = match indices.index_type() {
            IndexType::U8 => DataType::U8,
            IndexType::U16 => DataType::U16,
            IndexType::U32 => DataType::U32,
        };
        let beyond = || fault("its sparse values reach beyond their buffer");
        let bytes = content(model, &indices.view(), indices.offset()).ok_or_else(beyond)?;
        let integer = |bytes: &[u8]| value(bytes, index_kind, false);
        let places = read(bytes, sparse.count(), 1, index_kind.size(), index_kind.size(), integer).ok_or_else(beyond)?;
        let bytes = content(model, &replacements.view(), replacements.offset()).ok_or_else(beyond)?;
        let stride = columns * kind.size();
        let new = read(bytes, sparse.count(), columns, stride, kind.size(), number).ok_or_else(beyond)?;
        for (&place, row) in places.iter().zip(new.chunks_exact(columns)) {
            let start = place as usize * columns;
            let old = values.get_mut(start..start + columns).ok_or_else(|| fault("a sparse index is too large"))?;
            old.copy_from_slice(row);
        }
    }
    Ok(Rows { columns, values })
}

fn content<'m>(model: &'m Model, view: &gltf::buffer::View, offset: usize) -> Option<&'m [u8]> {
    let all = model.buffers.get(view.buffer().index())?;
    all.get(view.offset()..view.offset().checked_add(view.length())?)?.get(offset..)
}

fn read(
    bytes: &[u8],
    count: usize,
    columns: usize,
    stride: usize,
    size: usize,
    number: impl Fn(&[u8]) -> f64,
) -> Option<Vec<f64>> {
    let last = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(columns * size))?;
    if last > bytes.len() {
        return None;
    }
    let row = |row: usize| (0..columns).map(move |column| row * stride + column * size);
    Some((0..count).flat_map(row).map(|at| number(&bytes[at..at + size])).collect())
}

fn value(bytes: &[u8], kind: DataType, normalized: bool) -> f64 {
    let (value, largest) = match (kind, bytes) {
        (DataType::I8, &[a]) => (f64::from(a as i8), 127.0),
        (DataType::U8, &[a]) => (f64::from(a), 255.0),
        (DataType::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), 32767.0),
        (DataType::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), 65535.0),
        (DataType::U32, &[a, b, c, d]) => (f64::from(u32::from_le_bytes([a, b, c, d])), 1.0),
        (DataType::F32, &[a, b, c, d]) => (f64::from(f32::from_le_bytes([a, b, c, d])), 1.0),
        _ => (0.0, 1.0),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
