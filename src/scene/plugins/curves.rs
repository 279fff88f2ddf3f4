//! Shapes `linearcurve` and `bsplinecurve`: tubes of triangles, which do not emit.

use std::collections::HashMap;
use std::sync::Arc;

use super::shape::{Geometry, MeshFile, Shape};
use super::transform::orthogonal;
use crate::Result;
use crate::scene::description::object::Object;
use crate::scene::mesh::rings::Kind;
use crate::scene::mesh::{Mesh, MeshFormat};

/// Kind of curves of a geometry; `None` for other shapes.
pub(super) fn kind(geometry: &Geometry) -> Option<Kind> {
    match geometry {
        Geometry::Mesh(MeshFile { format: MeshFormat::Curves(curves), .. }, _) => Some(curves.kind),
        _ => None,
    }
}

/// Refuses an emitter within a shape of curves, as Mitsuba does.
pub(super) fn check_emitter(kind: Kind, emitter: Option<&Object>) -> Result<()> {
    let Some(emitter) = emitter else { return Ok(()) };
    let plugin = &emitter.plugin;
    let message = format!("emitter plugin `{plugin}` is not supported in shape `{}`", kind.plugin());
    Err(emitter.error(message + ", nor in Mitsuba; use `cylinder`, `sphere` or a mesh"))
}

/// Refuses curves that change their size while they move: a transform does not scale their radii.
pub(super) fn check_keys(shape: &Shape) -> Result<()> {
    let mut keys = shape.keys.iter().flat_map(|keys| keys.iter());
    match kind(&shape.geometry).is_none() || keys.all(|(_, key)| orthogonal(key).is_some()) {
        true => Ok(()),
        false => Err(shape.origin.error("curves that move must keep their size; do not scale their `to_world`")),
    }
}

/// Warning that curves are rendered as meshes, at the first shape that has some.
pub(super) fn warning(shapes: &[Shape], meshes: &HashMap<MeshFile, Arc<Mesh>>) -> Option<String> {
    let curves: Vec<_> = shapes.iter().filter(|shape| kind(&shape.geometry).is_some()).collect();
    let of = |shape: &&Shape| match &shape.geometry {
        Geometry::Mesh(file, _) => meshes.get(file).map(|mesh| &**mesh),
        _ => None,
    };
    let meshes: Vec<&Mesh> = curves.iter().filter_map(of).collect();
    let count: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let percent = 100.0 * meshes.iter().map(|mesh| mesh.deviation).fold(0.0, f32::max);
    let location = &curves.first()?.origin;
    Some(format!(
        "{location}: curves are rendered as {count} triangles, which are at most {percent:.2} % of the radius off their surface"
    ))
}
