//! Primitives of all shapes.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::shape::{self, Geometry, MeshFile, Shape};
use crate::Result;
use crate::scene::deformation::split_off;
use crate::scene::mesh::{MAX_TRIANGLES, Mesh};
use crate::scene::objects::{Names, Objects, Run};
use crate::scene::{Group, Primitive};

/// Primitives that are made of shapes.
pub(super) struct Made {
    pub world: Group,
    pub groups: Vec<Group>,
    pub objects: Objects,
}

/// Makes all primitives, in the order of the shapes: those of the world and those of the groups, whose first shapes are given. `names`
/// are those of the instances.
pub(super) fn of_shapes(
    shapes: &[Shape],
    groups: &[usize],
    names: &[Option<Arc<str>>],
    meshes: &HashMap<MeshFile, Arc<Mesh>>,
    deforms: bool,
) -> Result<Made> {
    check_size(shapes, meshes)?;
    let placed: Vec<_> = shapes.par_iter().map(|shape| shape::place(shape, meshes, deforms)).collect();
    let placed: Vec<_> = placed.into_iter().collect::<Result<_>>()?;
    let mut ends = Vec::with_capacity(placed.len());
    let mut count = 0;
    for shape in &placed {
        count += shape.len();
        ends.push(count);
    }
    let primitive = |index: usize| {
        let shape = ends.partition_point(|&end| end <= index);
        placed[shape].primitive(index + placed[shape].len() - ends[shape])
    };
    let mut primitives: Vec<Primitive> = (0..count).into_par_iter().map(primitive).collect();
    let firsts = ends.par_iter().zip(&placed).map(|(end, shape)| (end - shape.len(), shape));
    let mut deformations: Vec<_> = firsts.filter_map(|(first, shape)| shape.deformation(first)).collect();
    let first_primitives = groups.iter().rev().map(|&first| first.checked_sub(1).map_or(0, |before| ends[before]));
    let group = |first: usize| {
        let deformations = split_off(&mut deformations, first);
        Group { primitives: primitives.split_off(first), deformations }
    };
    let mut of_groups: Vec<Group> = first_primitives.map(group).collect();
    of_groups.reverse();
    let first_of_groups = groups.first().map_or(shapes.len(), |&first| first);
    let objects = objects(shapes, &ends, first_of_groups, names);
    Ok(Made { world: Group { primitives, deformations }, groups: of_groups, objects })
}

/// Objects of shapes, each of whose primitives end before an index. Shapes from `first_of_groups` on belong to groups.
fn objects(shapes: &[Shape], ends: &[usize], first_of_groups: usize, instances: &[Option<Arc<str>>]) -> Objects {
    let mut names = Names::default();
    let before = first_of_groups.checked_sub(1).map_or(0, |last| ends[last]);
    let mut runs = |shapes: &[Shape], ends: &[usize], before: usize| {
        let mut runs: Vec<Run> = Vec::new();
        for (shape, end) in shapes.iter().zip(ends) {
            let (end, name) = (end - before, names.index(&shape.name));
            match runs.last_mut() {
                Some(last) if last.name == name => last.end = end,
                _ => runs.push(Run { end, name }),
            }
        }
        runs
    };
    let of_primitives = runs(&shapes[..first_of_groups], &ends[..first_of_groups], 0);
    let of_groups = runs(&shapes[first_of_groups..], &ends[first_of_groups..], before);
    let of_instances = instances.iter().map(|name| name.as_ref().map(|name| names.index(name))).collect();
    Objects { names: names.into_list(), of_primitives, of_groups, of_instances }
}

/// Refuses scenes larger than any device could hold, before memory is allocated.
fn check_size(shapes: &[Shape], meshes: &HashMap<MeshFile, Arc<Mesh>>) -> Result<()> {
    let count = |shape: &Shape| match &shape.geometry {
        Geometry::Mesh(..) | Geometry::Unit(_) => shape::primitive_count(shape, meshes),
        _ => 0,
    };
    let mut triangles = 0;
    for shape in shapes {
        triangles += count(shape);
        if triangles > MAX_TRIANGLES {
            let all: usize = shapes.iter().map(count).sum();
            let message = format!(
                "with this shape the scene has {triangles} triangles, and {all} with all shapes; no more than {MAX_TRIANGLES} fit"
            );
            return Err(shape.origin.error(message));
        }
    }
    Ok(())
}
