//! Primvars: values on a shape, with their interpolation.

use std::collections::BTreeMap;
use std::rc::Rc;

use openusd::sdf;

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

/// Constant primvars that prims have from their parents: the parent of each, by the name without `primvars:`.
#[derive(Clone, Default)]
pub(super) struct Inherited(Rc<BTreeMap<String, sdf::Path>>);

impl Inherited {
    /// What the prims below a prim inherit, whose parent has these.
    pub fn below(&self, prim: &Prim) -> Result<Self> {
        let mut below = self.clone();
        for name in prim.names() {
            let Some(short) = name.strip_prefix("primvars:").filter(|short| !short.contains(':')) else { continue };
            if prim.value(name)?.is_none() {
                continue;
            }
            let interpolation = prim.metadata(name, "interpolation")?;
            let is_constant =
                interpolation.as_ref().and_then(values::text).is_none_or(|interpolation| interpolation == "constant");
            let map = Rc::make_mut(&mut below.0);
            // One that varies is that of a shape, and hides those above.
            match is_constant {
                true => map.insert(short.to_owned(), prim.path.clone()),
                false => map.remove(short),
            };
        }
        Ok(below)
    }

    /// Parent that a prim has a primvar from; `None` where it has its own, or none at all.
    pub fn parent(&self, prim: &Prim, name: &str) -> Result<Option<sdf::Path>> {
        match prim.value(&format!("primvars:{name}"))? {
            Some(_) => Ok(None),
            None => Ok(self.0.get(name).cloned()),
        }
    }

    /// Words that tell apart what is inherited.
    pub fn key(&self) -> String {
        self.0.iter().map(|(name, path)| format!("{name} {path} ")).collect()
    }
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
    /// One value for the whole shape.
    pub fn constant(value: T) -> Self {
        Self { values: vec![value], indices: None, interpolation: Interpolation::Constant }
    }

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
