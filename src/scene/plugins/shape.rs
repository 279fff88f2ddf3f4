//! Reader of `<shape>`. Parameters are read first; primitives are made when all mesh files are read.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use glam::{DMat4, DVec3};

use super::flatten::{self, Common, MeshOptions, PlacedMesh};
use super::properties::{Keys, Properties};
use super::{cylinder, transform};
use crate::Result;
use crate::scene::deformation::Deformation;
use crate::scene::description::object::{MESH, Object};
use crate::scene::description::origin::Origin;
use crate::scene::mesh::curves::CurveFormat;
use crate::scene::mesh::rings::Kind;
use crate::scene::mesh::{Mesh, MeshFormat};
use crate::scene::{Primitive, PrimitiveShape};

/// Plugin of a disk that faces what it lights.
pub(super) const FACING_DISK: &str = "facingdisk";

/// Largest relative deviation of a transform from a similarity: scene files are printed with six digits.
pub(super) const SIMILARITY: f64 = 1e-3;

/// Shape that is ready to be flattened.
#[derive(Clone)]
pub(super) struct Shape {
    pub geometry: Geometry,
    pub common: Common,
    /// Name of the object that it is a part of.
    pub name: Arc<str>,
    pub origin: Origin,
    /// Transforms at points in time that follow `common.to_world`, where the shape moves.
    pub keys: Option<Box<Keys>>,
}

/// Kinds of shape.
#[derive(Clone)]
pub(super) enum Geometry {
    Mesh(MeshFile, MeshOptions),
    Rectangle,
    Disk,
    Cube,
    Sphere,
    FacingDisk,
    /// Mesh of this program.
    Unit(&'static LazyLock<Mesh>),
}

/// Mesh: the canonical path of its file, and the file's format. A mesh in memory has no path.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct MeshFile {
    pub path: PathBuf,
    pub format: MeshFormat,
}

impl MeshFile {
    /// The mesh in memory with this index.
    pub fn in_memory(index: usize) -> Self {
        Self { path: PathBuf::new(), format: MeshFormat::Memory(index) }
    }

    /// Index of the mesh among those in memory; `None` where it is read from a file.
    pub fn index_in_memory(&self) -> Option<usize> {
        match self.format {
            MeshFormat::Memory(index) => Some(index),
            _ => None,
        }
    }
}

/// Reader of a plugin.
type Reader = fn(&mut Properties, &mut Common) -> Result<Geometry>;

/// Plugins that have primitives, with their readers.
const READERS: [(&str, Reader); 11] = [
    ("obj", |properties, common| parse_mesh(properties, MeshFormat::Obj, common)),
    ("ply", |properties, common| parse_mesh(properties, MeshFormat::Ply, common)),
    ("serialized", |properties, common| {
        parse_shape_index(properties).and_then(|format| parse_mesh(properties, format, common))
    }),
    ("rectangle", |properties, _| flat(properties, Geometry::Rectangle)),
    ("cube", |properties, _| flat(properties, Geometry::Cube)),
    ("sphere", |properties, common| parse_sphere(properties, common, Geometry::Sphere)),
    ("cylinder", |properties, common| parse_unit(properties, common, cylinder::parse, &cylinder::UNIT)),
    ("disk", |properties, _| flat(properties, Geometry::Disk)),
    (FACING_DISK, parse_facing_disk),
    ("linearcurve", |properties, common| parse_curves(properties, Kind::Linear, common)),
    ("bsplinecurve", |properties, common| parse_curves(properties, Kind::BSpline, common)),
];

/// Names of all plugins of shapes.
pub(super) fn plugins() -> impl Iterator<Item = &'static str> {
    READERS.iter().map(|(name, _)| *name).chain(["shapegroup", "instance"])
}

/// Reads the parameters of a shape's plugin, and its transform into `common`.
pub(super) fn parse_geometry(properties: &mut Properties, common: &mut Common) -> Result<Geometry> {
    common.to_world = properties.take_to_world()?;
    common.flip_normals = properties.boolean("flip_normals")?.unwrap_or(false);
    common.unseen = !properties.boolean("visible_to_camera")?.unwrap_or(true);
    let plugin = properties.plugin();
    if plugin == MESH
        && let Some(index) = properties.mesh(MESH)
    {
        return parse_mesh_in_memory(properties, index);
    }
    match READERS.iter().find(|(name, _)| *name == plugin) {
        Some((_, read)) => read(properties, common),
        None => Err(properties.owner().unsupported(&plugins().collect::<Vec<_>>())),
    }
}

/// A shape without parameters.
fn flat(properties: &mut Properties, geometry: Geometry) -> Result<Geometry> {
    ignore_faces(properties);
    Ok(geometry)
}

/// Passes over a parameter of meshes: the other shapes have flat faces, or none.
fn ignore_faces(properties: &mut Properties) {
    properties.ignore(&["face_normals"]);
}

/// Reads a shape that is a mesh of this program. `parse` reads the parameters and gives the transform of the mesh.
fn parse_unit(
    properties: &mut Properties,
    common: &mut Common,
    parse: fn(&mut Properties, DMat4) -> Result<DMat4>,
    unit: &'static LazyLock<Mesh>,
) -> Result<Geometry> {
    ignore_faces(properties);
    common.to_world = parse(properties, common.to_world)?;
    Ok(Geometry::Unit(unit))
}

/// Reads a shape whose mesh lies in memory already: of a dictionary, a glTF model or a pbrt scene.
fn parse_mesh_in_memory(properties: &mut Properties, index: usize) -> Result<Geometry> {
    let face_normals = properties.boolean("face_normals")?.unwrap_or(false);
    let flip_uvs = properties.boolean("flip_tex_coords")?.unwrap_or(false);
    Ok(Geometry::Mesh(MeshFile::in_memory(index), MeshOptions { face_normals, flip_uvs }))
}

fn parse_mesh(properties: &mut Properties, format: MeshFormat, common: &mut Common) -> Result<Geometry> {
    common.front_only = properties.boolean("front_only")?.unwrap_or(false);
    let flips_uvs = match format {
        MeshFormat::Serialized(_) => Some(false),
        _ => properties.boolean("flip_tex_coords")?,
    };
    let options = MeshOptions {
        face_normals: properties.boolean("face_normals")?.unwrap_or(false),
        flip_uvs: flips_uvs.unwrap_or(format == MeshFormat::Obj),
    };
    Ok(Geometry::Mesh(MeshFile { path: properties.file("filename", "mesh file")?.0.path, format }, options))
}

fn parse_shape_index(properties: &mut Properties) -> Result<MeshFormat> {
    let index = properties.integer("shape_index", 0..=i64::from(u32::MAX))?;
    Ok(MeshFormat::Serialized(index.unwrap_or(0) as usize))
}

/// Reads the parameters of a shape of curves. The transform is taken from `common`, because it moves the control points
/// but does not scale their radii.
fn parse_curves(properties: &mut Properties, kind: Kind, common: &mut Common) -> Result<Geometry> {
    if common.flip_normals {
        let message = format!("a `{}` has no `flip_normals`, because it is seen from outside only", kind.plugin());
        return Err(properties.owner().error(message + "; leave it out"));
    }
    ignore_faces(properties);
    common.front_only = true;
    let to_world = std::mem::replace(&mut common.to_world, DMat4::IDENTITY);
    // Weight of Mitsuba's derivatives with respect to the shape.
    properties.ignore(&["silhouette_sampling_weight"]);
    let format = MeshFormat::Curves(CurveFormat::new(kind, &to_world));
    let options = MeshOptions { face_normals: false, flip_uvs: false };
    Ok(Geometry::Mesh(MeshFile { path: properties.file("filename", "curve file")?.0.path, format }, options))
}

/// Reads a disk that faces what it lights.
fn parse_facing_disk(properties: &mut Properties, common: &mut Common) -> Result<Geometry> {
    let geometry = parse_sphere(properties, common, Geometry::FacingDisk)?;
    if common.flip_normals {
        let message = "a `facingdisk` has no `flip_normals`, because it faces what it lights; leave it out";
        return Err(properties.owner().error(message));
    }
    Ok(geometry)
}

/// Reads a shape with a center and a radius. The transform goes from the unit sphere to the world.
fn parse_sphere(properties: &mut Properties, common: &mut Common, geometry: Geometry) -> Result<Geometry> {
    ignore_faces(properties);
    let object = properties.owner();
    let center = properties.point("center")?.unwrap_or(DVec3::ZERO);
    let radius = f64::from(properties.positive_float("radius", 1.0)?);
    let result = common.to_world * DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(radius));
    if !transform::is_similarity(&result, SIMILARITY) {
        return Err(object.error(format!("the `to_world` of a {} must not scale unevenly or shear", object.plugin)));
    }
    if transform::axes(&result)[0].as_vec3().length_squared() < f32::MIN_POSITIVE {
        return Err(object.error(format!("a {} needs a radius greater than 0", object.plugin)));
    }
    common.to_world = result;
    Ok(geometry)
}

impl Shape {
    /// Plugin of a shape that has the same radius to all sides.
    fn round_plugin(&self) -> Option<&'static str> {
        match self.geometry {
            Geometry::Sphere => Some("sphere"),
            Geometry::FacingDisk => Some(FACING_DISK),
            _ => None,
        }
    }

    /// Checks that an `instance` can show this shape of its group.
    pub fn check_instance(&self, to_world: &DMat4, instance: &Object) -> Result<()> {
        if let Some(plugin) = self.round_plugin()
            && !transform::is_similarity(to_world, SIMILARITY)
        {
            let message = format!("an instance with a {plugin} must not be scaled unevenly or sheared");
            return Err(instance.error(message));
        }
        Ok(())
    }

    /// Checks that the shape keeps its kind while it moves.
    pub fn check_keys(&self) -> Result<()> {
        let matrices = || self.keys.iter().flat_map(|keys| keys.iter()).map(|(_, matrix)| matrix);
        if let Some(plugin) = self.round_plugin()
            && !matrices().all(|key| transform::is_similarity(key, SIMILARITY))
        {
            let message = format!("the `to_world` of a {plugin} must not scale unevenly or shear");
            return Err(self.origin.error(message));
        }
        Ok(())
    }
}

/// Most primitives that a shape consists of.
pub(super) fn primitive_count(shape: &Shape, meshes: &HashMap<MeshFile, Arc<Mesh>>) -> usize {
    match &shape.geometry {
        Geometry::Mesh(file, _) => meshes.get(file).map_or(0, |mesh| mesh.triangles.len()),
        Geometry::Unit(mesh) => mesh.triangles.len(),
        Geometry::Cube => 6,
        Geometry::Rectangle | Geometry::Disk | Geometry::Sphere | Geometry::FacingDisk => 1,
    }
}

/// Shape whose primitives can be made one by one.
pub(super) enum Placed<'a> {
    Mesh(Box<PlacedMesh<'a>>),
    Few(Vec<Primitive>),
}

/// Places a shape; `meshes` holds every mesh that a shape names. Meshes may change their shape where `deforms` is true.
pub(super) fn place<'a>(shape: &Shape, meshes: &'a HashMap<MeshFile, Arc<Mesh>>, deforms: bool) -> Result<Placed<'a>> {
    let common = &shape.common;
    let mesh =
        |mesh, options: &_| PlacedMesh::new(mesh, options, common, deforms).map(|mesh| Placed::Mesh(Box::new(mesh)));
    let placed = match &shape.geometry {
        Geometry::Mesh(file, options) => match meshes.get(file) {
            Some(found) => mesh(found, options),
            None => Some(Placed::Few(Vec::new())),
        },
        Geometry::Rectangle => few(flatten::flat(PrimitiveShape::Parallelogram, common), common),
        Geometry::Disk => few(flatten::flat(PrimitiveShape::Disk, common), common),
        Geometry::Cube => few(flatten::cube(common), common),
        Geometry::Sphere => few(vec![flatten::sphere(common)], common),
        Geometry::FacingDisk => few(vec![flatten::facing_disk(common)], common),
        Geometry::Unit(unit) => mesh(unit, &MeshOptions { face_normals: false, flip_uvs: false }),
    };
    placed.ok_or_else(|| {
        shape.origin.error("the shape's `to_world` takes it out of the range of single-precision numbers")
    })
}

fn few<'a>(primitives: Vec<Primitive>, common: &Common) -> Option<Placed<'a>> {
    let instantiated = |p: Primitive| flatten::instantiated(p, &common.instance_to_world);
    let primitives: Vec<_> = primitives.into_iter().filter_map(instantiated).collect();
    let is_finite = |p: &Primitive| p.origin.is_finite() && p.edge_u.cross(p.edge_v).length_squared().is_finite();
    primitives.iter().all(is_finite).then_some(Placed::Few(primitives))
}

impl Placed<'_> {
    /// Number of primitives.
    pub fn len(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.len(),
            Self::Few(primitives) => primitives.len(),
        }
    }

    /// Deformation of the shape, whose first primitive has the index `first`; `None` where it keeps its shape.
    pub fn deformation(&self, first: usize) -> Option<Deformation> {
        let Self::Mesh(mesh) = self else { return None };
        let intervals = Some(mesh.intervals() as u32).filter(|&intervals| intervals > 0 && mesh.len() > 0)?;
        let keys = (0..mesh.len()).flat_map(|index| mesh.keys(index)).collect();
        Some(Deformation { first: first as u32, intervals, keys })
    }

    /// Makes primitive number `index`.
    pub fn primitive(&self, index: usize) -> Primitive {
        match self {
            Self::Mesh(mesh) => mesh.triangle(index),
            Self::Few(primitives) => primitives[index],
        }
    }
}
