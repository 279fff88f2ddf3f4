//! Primvars: values on a shape, with their interpolation.

use super::asset::Prim;
use super::values;
use crate::Result;

/// How the values of a primvar lie on a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// One for the whole shape.
    Constant,
    /// One for each face.
    Uniform,
    /// One for each point.
    Vertex,
    /// One for each corner of each face.
    FaceVarying,
}

/// Values on a shape.
pub(super) struct Primvar<T> {
    pub values: Vec<T>,
    indices: Option<Vec<usize>>,
    pub interpolation: Interpolation,
}

/// Place on a mesh: indices of its face, its point, and its corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub face: usize,
    pub point: usize,
    pub corner: usize,
}

/// Number of faces, points and corners of a mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counts {
    pub faces: usize,
    pub points: usize,
    pub corners: usize,
}

impl<T> Primvar<T> {
    /// The attribute `name` with its indices; `None` where the prim has none. One of another length than the shape's is told and ignored.
    pub fn read(
        prim: &Prim,
        name: &str,
        default: Interpolation,
        counts: Counts,
        of: impl Fn(&openusd::sdf::Value) -> Option<Vec<T>>,
    ) -> Result<Option<Self>> {
        let Some(values) = prim.read(name, of)? else { return Ok(None) };
        let metadata = prim.metadata(name, "interpolation")?;
        let interpolation = match metadata.as_ref().and_then(values::text).as_deref() {
            Some("constant") => Interpolation::Constant,
            Some("uniform") => Interpolation::Uniform,
            Some("vertex" | "varying") => Interpolation::Vertex,
            Some("faceVarying") => Interpolation::FaceVarying,
            _ => default,
        };
        let indices = prim.read(&format!("{name}:indices"), values::indices)?;
        let count = match interpolation {
            Interpolation::Constant => 1,
            Interpolation::Uniform => counts.faces,
            Interpolation::Vertex => counts.points,
            Interpolation::FaceVarying => counts.corners,
        };
        let given = indices.as_ref().map_or(values.len(), Vec::len);
        let in_range = indices.as_ref().is_none_or(|list| list.iter().all(|&index| index < values.len()));
        if given < count || values.is_empty() || !in_range {
            if given > 0 || count > 0 {
                let message = format!("`{name}` has {given} values or indices for {count} places; it is ignored");
                prim.asset.warn_of(&prim.path, message);
            }
            return Ok(None);
        }
        Ok(Some(Self { values, indices, interpolation }))
    }

    /// Index of the value at a corner.
    pub fn index(&self, corner: Corner) -> usize {
        let place = match self.interpolation {
            Interpolation::Constant => 0,
            Interpolation::Uniform => corner.face,
            Interpolation::Vertex => corner.point,
            Interpolation::FaceVarying => corner.corner,
        };
        self.indices.as_ref().map_or(place, |indices| indices[place])
    }
}

impl<T> Primvar<T> {
    /// One value for each point.
    pub fn of_points(values: Vec<T>) -> Self {
        Self { values, indices: None, interpolation: Interpolation::Vertex }
    }
}

impl<T> Primvar<T> {
    /// Index of the first value.
    pub fn first(&self) -> usize {
        self.index(Corner { face: 0, point: 0, corner: 0 })
    }
}
