//! Meshes of polygons.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{Vec2, Vec3};
use openusd::sdf;

use super::asset::Prim;
use super::budget::Made;
use super::primvars::{Corner, Counts, Interpolation, Primvar};
use super::values;
use crate::Result;
use crate::scene::mesh::{Cutter, Mesh};

/// Faces and points of a mesh.
pub(super) struct Faces {
    points: Vec<Vec3>,
    /// First corner of each face, and the number of all corners.
    firsts: Vec<usize>,
    /// Point of each corner.
    indices: Vec<usize>,
    holes: Vec<bool>,
    is_left_handed: bool,
    pub is_subdivided: bool,
    pub counts: Counts,
}

/// What a mesh has beside its points.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Shown {
    /// Primvar of texture coordinates.
    pub uvs: Option<Named>,
    /// Primvar of colors.
    pub colors: Option<Named>,
    /// Whether the triangles are turned over, because the shape is mirrored.
    pub is_mirrored: bool,
}

/// A primvar of a mesh.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Named {
    pub name: String,
    /// Parent that the mesh has it from; `None` where it is its own.
    pub parent: Option<sdf::Path>,
}

impl Named {
    fn read<T>(
        &self,
        prim: &Prim,
        counts: Counts,
        of: impl Fn(&sdf::Value) -> Option<Vec<T>>,
    ) -> Result<Option<Primvar<T>>> {
        let name = format!("primvars:{}", self.name);
        match &self.parent {
            Some(parent) => Primvar::read(&prim.asset.prim(parent)?, &name, Interpolation::Constant, counts, of),
            None => Primvar::read(prim, &name, Interpolation::Constant, counts, of),
        }
    }
}

impl Faces {
    /// Reads the faces of a mesh; `None` where it has none, or a fault, which is told.
    pub fn read(prim: &Prim, made: &mut Made) -> Result<Option<Self>> {
        let left_out = |message: &str| {
            prim.asset.warn_of(&prim.path, format!("{message}; it is not rendered"));
            Ok(None)
        };
        let points = prim.read("points", values::triples)?.unwrap_or_default();
        let lengths = prim.read("faceVertexCounts", values::indices)?.unwrap_or_default();
        let indices = prim.read("faceVertexIndices", values::indices)?.unwrap_or_default();
        if points.is_empty() || lengths.is_empty() {
            return left_out("the mesh has no points or no faces");
        }
        let counted = made.corners(indices.len()).and_then(|()| made.corners(points.len()));
        counted.map_err(|message| prim.asset.prim_error(&prim.path, message))?;
        let points: Vec<Vec3> = points.iter().map(|point| Vec3::from_array(point.map(|c| c as f32))).collect();
        if !points.iter().all(|point| point.is_finite()) {
            return left_out("a point of the mesh is not finite");
        }
        let (mut firsts, mut next) = (vec![0], 0_usize);
        for &length in &lengths {
            next = next.saturating_add(length);
            firsts.push(next);
        }
        if firsts.last().is_some_and(|&corners| corners > indices.len()) {
            return left_out("`faceVertexCounts` ask for more corners than `faceVertexIndices` has");
        }
        if indices.iter().any(|&index| index >= points.len()) {
            return left_out("an index of `faceVertexIndices` is larger than the number of points");
        }
        let mut holes = vec![false; lengths.len()];
        for index in prim.read("holeIndices", values::indices)?.unwrap_or_default() {
            if let Some(hole) = holes.get_mut(index) {
                *hole = true;
            }
        }
        let scheme = prim.text("subdivisionScheme")?;
        let counts = Counts { faces: lengths.len(), points: points.len(), corners: indices.len() };
        Ok(Some(Self {
            points,
            firsts,
            indices,
            holes,
            is_left_handed: prim.text("orientation")?.as_deref() == Some("leftHanded"),
            is_subdivided: scheme.as_deref() != Some("none"),
            counts,
        }))
    }

    /// Mesh of some of the faces, or of all; `None` where there are no triangles.
    pub fn mesh(&self, prim: &Prim, shown: &Shown, part: Option<&[usize]>) -> Result<Option<Mesh>> {
        let normals = self.normals(prim)?;
        let read_uvs = |named: &Named| named.read(prim, self.counts, values::pairs);
        let mut uvs = shown.uvs.as_ref().map(read_uvs).transpose()?.flatten();
        if let (Some(named), None) = (&shown.uvs, &uvs) {
            let message =
                format!("it lacks the primvar `{}` that its textures ask for; they are read at (0, 0)", named.name);
            prim.asset.warn_of(&prim.path, message);
            uvs = Some(Primvar::constant([0.0; 2]));
        }
        let read_colors = |named: &Named| named.read(prim, self.counts, values::triples);
        let colors = shown.colors.as_ref().map(read_colors).transpose()?.flatten();
        let all: Vec<usize>;
        let faces = match part {
            Some(part) => part,
            None => {
                all = (0..self.counts.faces).collect();
                &all
            }
        };
        let mut mesh = Mesh::default();
        let mut vertices: HashMap<[u32; 4], u32> = HashMap::new();
        let (mut cutter, mut polygon) = (Cutter::default(), Vec::new());
        let turns = self.is_left_handed != shown.is_mirrored;
        for &face in faces {
            let (Some(&first), Some(&end)) = (self.firsts.get(face), self.firsts.get(face + 1)) else { continue };
            if self.holes[face] {
                continue;
            }
            polygon.clear();
            for corner in first..end {
                let place = Corner { face, point: self.indices[corner], corner };
                let index = |primvar: Option<usize>| primvar.map_or(u32::MAX, |index| index as u32);
                let normal = index(normals.as_ref().map(|primvar| primvar.index(place)));
                let uv = index(uvs.as_ref().map(|primvar| primvar.index(place)));
                let color = index(colors.as_ref().map(|primvar| primvar.index(place)));
                let vertex = match vertices.entry([place.point as u32, normal, uv, color]) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(free) => {
                        let vertex = mesh.positions.len() as u32;
                        mesh.positions.push(self.points[place.point]);
                        if let Some(primvar) = &normals {
                            mesh.normals.push(vector(primvar.values[normal as usize]));
                        }
                        if let Some(primvar) = &uvs {
                            // USD's t points up in the image, Lodestar's v down.
                            let [s, t] = primvar.values[uv as usize];
                            mesh.uvs.push(Vec2::new(s as f32, (1.0 - t) as f32));
                        }
                        if let Some(primvar) = &colors {
                            mesh.colors.push(vector(primvar.values[color as usize]).clamp(Vec3::ZERO, Vec3::ONE));
                        }
                        *free.insert(vertex)
                    }
                };
                polygon.push(vertex);
            }
            let added = cutter.add(&mut mesh.triangles, &polygon, &mesh.positions);
            added.map_err(|message| prim.asset.prim_error(&prim.path, message))?;
        }
        if !mesh.uvs.iter().all(|uv| uv.is_finite()) {
            return Err(prim.asset.prim_error(&prim.path, "a texture coordinate is not finite"));
        }
        if turns {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(Some(mesh).filter(|mesh| !mesh.triangles.is_empty()))
    }

    /// Normals of the file, or those of a smooth surface where the mesh is one to be subdivided.
    fn normals(&self, prim: &Prim) -> Result<Option<Primvar<[f64; 3]>>> {
        for name in ["primvars:normals", "normals"] {
            let found = Primvar::read(prim, name, Interpolation::Vertex, self.counts, values::triples)?;
            if found.is_some() {
                return Ok(found);
            }
        }
        if !self.is_subdivided {
            return Ok(None);
        }
        let mut sums = vec![Vec3::ZERO; self.points.len()];
        for (face, hole) in self.holes.iter().enumerate() {
            let corners = &self.indices[self.firsts[face]..self.firsts[face + 1]];
            let Some((&origin, rest)) = corners.split_first().filter(|_| !hole) else { continue };
            let at = |point: usize| self.points[point] - self.points[origin];
            let area: Vec3 = rest.windows(2).map(|pair| at(pair[0]).cross(at(pair[1]))).sum();
            corners.iter().for_each(|&point| sums[point] += area);
        }
        let sign = if self.is_left_handed { -1.0 } else { 1.0 };
        let normals = sums.iter().map(|sum| (sign * sum.normalize_or_zero()).as_dvec3().to_array()).collect();
        Ok(Some(Primvar::of_points(normals)))
    }
}

/// A part of a mesh with a material of its own (`GeomSubset`).
pub(super) struct Subset {
    pub path: sdf::Path,
    pub faces: Vec<usize>,
}

/// Parts of a mesh, by the prims beneath it, and the faces that are in none of them.
pub(super) fn subsets(prim: &Prim, faces: usize) -> Result<(Vec<Subset>, Vec<usize>)> {
    let mut taken = vec![false; faces];
    let mut subsets = Vec::new();
    for path in prim.children()? {
        let child = prim.asset.prim(&path)?;
        if child.kind != "GeomSubset" {
            continue;
        }
        let family = child.text("familyName")?.unwrap_or_default();
        let element = child.text("elementType")?.unwrap_or_else(|| "face".to_owned());
        if !["", "materialBind"].contains(&&*family) || element != "face" {
            continue;
        }
        let mut own = child.read("indices", values::indices)?.unwrap_or_default();
        own.retain(|&face| taken.get_mut(face).is_some_and(|taken| !std::mem::replace(taken, true)));
        subsets.push(Subset { path, faces: own });
    }
    let rest = (0..faces).filter(|&face| !taken[face]).collect();
    Ok((subsets, rest))
}

fn vector(values: [f64; 3]) -> Vec3 {
    Vec3::from_array(values.map(|value| value as f32))
}
