//! Typed data of accessors, with every bound checked.

use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};

use super::asset::Asset;
use super::usual::MAX_ZEROS;
use crate::Result;

/// Most elements of one accessor.
const MAX_COUNT: usize = 1 << 28;

/// Place of elements in a buffer.
struct Source<'a> {
    bytes: &'a [u8],
    stride: usize,
    kind: DataType,
    normalized: bool,
}

impl Source<'_> {
    /// Component `component` of element `index`.
    fn number(&self, index: usize, component: usize) -> Option<f64> {
        let at = index.checked_mul(self.stride)?.checked_add(component * self.kind.size())?;
        let bytes = self.bytes.get(at..at + self.kind.size())?;
        let (value, largest) = match (self.kind, bytes) {
            (DataType::I8, &[a]) => (f64::from(a as i8), f64::from(i8::MAX)),
            (DataType::U8, &[a]) => (f64::from(a), f64::from(u8::MAX)),
            (DataType::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX)),
            (DataType::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX)),
            (DataType::U32, &[a, b, c, d]) => (f64::from(u32::from_le_bytes([a, b, c, d])), f64::from(u32::MAX)),
            (DataType::F32, &[a, b, c, d]) => (f64::from(f32::from_le_bytes([a, b, c, d])), 1.0),
            _ => return None,
        };
        Some(if self.normalized && self.kind != DataType::F32 { (value / largest).max(-1.0) } else { value })
    }
}

impl Asset {
    /// Elements of an accessor, with the first `N` components of each.
    ///
    /// # Errors
    /// Where an element has fewer components, or lies outside its buffer.
    pub fn elements<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f64; N]>> {
        let (count, components) = (accessor.count(), components(accessor.dimensions()));
        let fault = |what: &str| self.error(format!("accessor {}: {what}", accessor.index()));
        if components < N {
            return Err(fault(&format!("its elements have {components} components, but {N} are needed")));
        }
        let outside = || fault("it reaches beyond its buffer: is the file cut short?");
        let most = if accessor.view().is_some() { MAX_COUNT } else { MAX_ZEROS };
        if count > most {
            return Err(fault(&format!("it has {count} elements, too many values; no more than {most} are read")));
        }
        self.count_zeros(accessor.view().as_ref(), count).map_err(|message| fault(&message))?;
        if let Some(view) = accessor.view() {
            // The last element must lie in the buffer, before memory is set aside for all.
            let stride = view.stride().unwrap_or(accessor.size());
            let end = count.saturating_sub(1).checked_mul(stride).and_then(|end| end.checked_add(accessor.size()));
            let held = self.view(&view)?.len().saturating_sub(accessor.offset());
            if count > 0 && end.is_none_or(|end| end > held) {
                return Err(outside());
            }
        }
        let mut elements = vec![[0.0; N]; count];
        let read = |source: &Source, index: usize| -> Option<[f64; N]> {
            let mut element = [0.0; N];
            for (component, value) in element.iter_mut().enumerate() {
                *value = source.number(index, component)?;
            }
            Some(element)
        };
        if let Some(view) = accessor.view() {
            let bytes = self.view(&view)?.get(accessor.offset()..).ok_or_else(outside)?;
            let stride = view.stride().unwrap_or(accessor.size());
            let source = Source { bytes, stride, kind: accessor.data_type(), normalized: accessor.normalized() };
            for (index, element) in elements.iter_mut().enumerate() {
                *element = read(&source, index).ok_or_else(outside)?;
            }
        }
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let kind = match indices.index_type() {
                gltf::accessor::sparse::IndexType::U8 => DataType::U8,
                gltf::accessor::sparse::IndexType::U16 => DataType::U16,
                gltf::accessor::sparse::IndexType::U32 => DataType::U32,
            };
            let view = indices.view();
            let bytes = self.view(&view)?.get(indices.offset()..).ok_or_else(outside)?;
            let places = Source { bytes, stride: view.stride().unwrap_or(kind.size()), kind, normalized: false };
            let view = values.view();
            let bytes = self.view(&view)?.get(values.offset()..).ok_or_else(outside)?;
            let stride = view.stride().unwrap_or(accessor.size());
            let values = Source { bytes, stride, kind: accessor.data_type(), normalized: accessor.normalized() };
            for index in 0..sparse.count() {
                let place = places.number(index, 0).ok_or_else(outside)? as usize;
                let value = read(&values, index).ok_or_else(outside)?;
                *elements.get_mut(place).ok_or_else(|| fault("a sparse index is too large"))? = value;
            }
        }
        Ok(elements)
    }
}

fn components(dimensions: Dimensions) -> usize {
    match dimensions {
        Dimensions::Scalar => 1,
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        Dimensions::Vec4 | Dimensions::Mat2 => 4,
        Dimensions::Mat3 => 9,
        Dimensions::Mat4 => 16,
    }
}
