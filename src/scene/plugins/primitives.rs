//! Primitives of all shapes.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::shape::{self, Geometry, MeshFile, Shape};
use crate::Result;
use crate::scene::deformation::split_off;
use crate::scene::mesh::{MAX_TRIANGLES, Mesh};
use crate::scene::{Group, Primitive};

/// Makes all primitives, in the order of the shapes: those of the world and those of the groups, whose first shapes are given.
pub(super) fn of_shapes(
    shapes: &[Shape],
    groups: &[usize],
    meshes: &HashMap<MeshFile, Arc<Mesh>>,
    deforms: bool,
) -> Result<(Group, Vec<Group>)> {
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
    let mut groups: Vec<Group> = first_primitives.map(group).collect();
    groups.reverse();
    Ok((Group { primitives, deformations }, groups))
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
