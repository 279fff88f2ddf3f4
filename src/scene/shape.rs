//! `<shape>`: what it asks for, read first; the primitives come when all mesh files are there.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3};

use super::document;
use super::element::{Element, Location};
use super::flatten::{self, Common, MeshOptions, PlacedMesh};
use super::mesh::{Mesh, MeshFormat};
use super::properties::Properties;
use super::transform;
use super::{Primitive, PrimitiveShape};
use crate::Result;

const SUPPORTED: [&str; 5] = ["obj", "rectangle", "cube", "sphere", "disk"];

/// A `<shape>`, ready to be flattened.
pub(super) struct Shape {
    pub geometry: Geometry,
    pub common: Common,
    pub location: Location,
}

/// The kinds of shape.
pub(super) enum Geometry {
    Mesh(MeshFile, MeshOptions),
    Rectangle,
    Disk,
    Cube,
    Sphere,
}

/// Which mesh to read: the canonical path of its file, and what that holds.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct MeshFile {
    pub path: PathBuf,
    pub format: MeshFormat,
}

/// Reads what is special to a shape's plugin, and its transform into `common`.
pub(super) fn parse_geometry(properties: &mut Properties, common: &mut Common, top_folder: &Path) -> Result<Geometry> {
    let element = properties.element();
    common.to_world = properties.take_to_world()?;
    common.flip_normals = properties.boolean("flip_normals")?.unwrap_or(false);
    if properties.plugin() != "obj" {
        // Their faces are flat anyway, and a sphere has none.
        properties.ignore(&["face_normals"]);
    }
    match properties.plugin() {
        "obj" => parse_obj(properties, top_folder),
        "rectangle" => Ok(Geometry::Rectangle),
        "disk" => Ok(Geometry::Disk),
        "cube" => Ok(Geometry::Cube),
        "sphere" => {
            common.to_world = parse_sphere(properties, common.to_world)?;
            Ok(Geometry::Sphere)
        }
        _ => Err(element.unsupported(&SUPPORTED)),
    }
}

fn parse_obj(properties: &mut Properties, top_folder: &Path) -> Result<Geometry> {
    let element = properties.element();
    let options = MeshOptions {
        face_normals: properties.boolean("face_normals")?.unwrap_or(false),
        flip_uvs: properties.boolean("flip_tex_coords")?.unwrap_or(true),
    };
    let parameter = properties.take("filename");
    let parameter = parameter.ok_or_else(|| element.error("shape plugin `obj` needs its parameter `filename`"))?;
    let file = MeshFile { path: find_mesh(parameter, top_folder)?, format: MeshFormat::Obj };
    Ok(Geometry::Mesh(file, options))
}

fn find_mesh(parameter: &Element, top_folder: &Path) -> Result<PathBuf> {
    let name = parameter.required("value")?;
    document::resolve(name, &parameter.location.file, top_folder)
        .and_then(|path| path.canonicalize().ok())
        .ok_or_else(|| parameter.error(format!("the mesh file `{name}` does not exist")))
}

/// World from the unit sphere.
fn parse_sphere(properties: &mut Properties, to_world: DMat4) -> Result<DMat4> {
    let element = properties.element();
    let center = properties.point("center")?.unwrap_or(DVec3::ZERO);
    let radius = f64::from(properties.positive_float("radius", 1.0)?);
    let result = to_world * DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(radius));
    // Scene files are printed with six digits.
    if !transform::is_similarity(&result, 1e-3) {
        return Err(element.error("the `to_world` of a sphere must not scale unevenly or shear"));
    }
    if transform::axes(&result)[0].as_vec3().length_squared() < f32::MIN_POSITIVE {
        return Err(element.error("a sphere needs a radius greater than 0"));
    }
    Ok(result)
}

/// A shape whose primitives can be made one by one.
pub(super) enum Placed<'a> {
    Mesh(PlacedMesh<'a>),
    Few(Vec<Primitive>),
}

/// Puts a shape in its place; `meshes` holds every mesh that a shape names.
pub(super) fn place<'a>(shape: &Shape, meshes: &'a HashMap<MeshFile, Mesh>) -> Result<Placed<'a>> {
    let common = &shape.common;
    let placed = match &shape.geometry {
        Geometry::Mesh(file, options) => match meshes.get(file) {
            Some(mesh) => PlacedMesh::new(mesh, options, common).map(Placed::Mesh),
            None => Some(Placed::Few(Vec::new())),
        },
        Geometry::Rectangle => few(flatten::flat(PrimitiveShape::Parallelogram, common)),
        Geometry::Disk => few(flatten::flat(PrimitiveShape::Disk, common)),
        Geometry::Cube => few(flatten::cube(common)),
        Geometry::Sphere => few(vec![flatten::sphere(common)]),
    };
    placed.ok_or_else(|| {
        shape.location.error("the shape's `to_world` takes it out of the range of single-precision numbers")
    })
}

fn few<'a>(primitives: Vec<Primitive>) -> Option<Placed<'a>> {
    let is_finite = |p: &Primitive| p.origin.is_finite() && p.edge_u.cross(p.edge_v).length_squared().is_finite();
    primitives.iter().all(is_finite).then_some(Placed::Few(primitives))
}

impl Placed<'_> {
    /// How many primitives it has.
    pub fn len(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.len(),
            Self::Few(primitives) => primitives.len(),
        }
    }

    /// Its primitive of that index.
    pub fn primitive(&self, index: usize) -> Primitive {
        match self {
            Self::Mesh(mesh) => mesh.triangle(index),
            Self::Few(primitives) => primitives[index],
        }
    }
}
