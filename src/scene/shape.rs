//! `<shape>`: what it asks for, read first; the primitives come when all mesh files are there.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3};

use super::document;
use super::element::{Element, Location};
use super::flatten::{self, Common, MeshOptions};
use super::mesh::Mesh;
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
    /// The canonical path of an OBJ file, and how to read it.
    Mesh(PathBuf, MeshOptions),
    Rectangle,
    Disk,
    Cube,
    Sphere,
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
    Ok(Geometry::Mesh(find_mesh(parameter, top_folder)?, options))
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

/// The shape's primitives; `meshes` holds every file that a shape names.
pub(super) fn flatten(shape: &Shape, meshes: &HashMap<PathBuf, Mesh>) -> Result<Vec<Primitive>> {
    let common = &shape.common;
    let primitives = match &shape.geometry {
        Geometry::Mesh(path, options) => match meshes.get(path) {
            Some(mesh) => flatten::mesh(mesh, options, common),
            None => Vec::new(),
        },
        Geometry::Rectangle => flatten::flat(PrimitiveShape::Parallelogram, common),
        Geometry::Disk => flatten::flat(PrimitiveShape::Disk, common),
        Geometry::Cube => flatten::cube(common),
        Geometry::Sphere => vec![flatten::sphere(common)],
    };
    let is_finite = |p: &Primitive| p.origin.is_finite() && p.edge_u.cross(p.edge_v).length_squared().is_finite();
    if primitives.iter().all(is_finite) {
        return Ok(primitives);
    }
    Err(shape.location.error("the shape's `to_world` takes it out of the range of single-precision numbers"))
}
