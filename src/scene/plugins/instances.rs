//! Instances: those of small groups become copies, those of large ones are kept.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat4, DVec3, Vec3};

use super::flatten::{Common, MeshOptions};
use super::properties::Keys;
use super::shape::{Geometry, MeshFile, SIMILARITY, Shape, primitive_count};
use super::transform::{is_mirrored, is_similarity};
use crate::Result;
use crate::scene::description::origin::Origin;
use crate::scene::mesh::Mesh;
use crate::scene::{Course, Instance, Motion};

/// Most shapes of a scene, with those of copies. A few instances of a large group can ask for more than any memory holds.
const MAX_SHAPES: usize = 1 << 20;
/// Most primitives that copies may add to those that a scene would store without them. Rays are faster through copies: see
/// `docs/scenes.md`.
const MOST_COPIED: u64 = 1 << 20;

/// Shape or instance that stands in the scene.
pub(super) enum Item<'a> {
    Shape(Box<Shape>),
    Instance(Placed<'a>),
}

/// Group in a place of the world.
pub(super) struct Placed<'a> {
    /// Index of the group.
    pub group: usize,
    pub to_world: DMat4,
    /// Transforms at points in time, where the instance moves.
    pub keys: Option<Box<Keys>>,
    /// Name of the instance, where it has one.
    pub name: Option<Arc<str>>,
    /// Place of the instance, for messages.
    pub origin: &'a Origin,
}

/// Shapes and instances of a scene, arranged.
#[derive(Default)]
pub(super) struct Arranged {
    /// Shapes of the world, then those of each group that is kept.
    pub shapes: Vec<Shape>,
    /// Index of the first shape of each group that is kept.
    pub groups: Vec<usize>,
    pub instances: Vec<Instance>,
    /// Name of each instance; `None` where the shapes of its group keep theirs.
    pub names: Vec<Option<Arc<str>>>,
    pub motions: Vec<Motion>,
}

/// Decides which instances become copies, and which shapes that share a mesh become instances.
pub(super) fn arrange(
    mut items: Vec<Item>,
    mut groups: Vec<Vec<Shape>>,
    meshes: &HashMap<MeshFile, Arc<Mesh>>,
    shutter: [f64; 2],
) -> Result<Arranged> {
    let mut moving = moving(&mut items, shutter)?;
    let shared = shared_meshes(&items, &moving, meshes);
    groups.extend(shared.iter().map(|indices| vec![in_mesh_space(&items, indices[0])]));
    let first_shared = groups.len() - shared.len();

    // Numbers of primitives and instances of each group. Spheres are copied in any case, and so are instances that have no inverse.
    let count = |shape: &Shape| if is_sphere(shape) { 0 } else { primitive_count(shape, meshes) as u64 };
    // A key of a triangle that deforms takes half as much as a triangle.
    let keyed = |shape: &Shape| count(shape) * (2 + set_count(shape, meshes)) / 2;
    let primitives: Vec<u64> = groups.iter().map(|shapes| shapes.iter().map(keyed).sum()).collect();
    let mut instances: Vec<u64> = vec![0; groups.len()];
    for (index, item) in items.iter().enumerate() {
        if let Item::Instance(placed) = item
            && !moving.contains_key(&index)
        {
            instances[placed.group] += u64::from(kept(0, &placed.to_world).is_some());
        }
    }
    for (group, indices) in (first_shared..).zip(&shared) {
        instances[group] = indices.len() as u64;
    }
    let is_copied = copied(&primitives, &instances);

    // Shapes that share a mesh which is kept become instances.
    let of_shape: HashMap<usize, usize> = (first_shared..)
        .zip(&shared)
        .filter(|&(group, _)| !is_copied[group])
        .flat_map(|(group, indices)| indices.iter().map(move |&index| (index, group)))
        .collect();
    drop(shared);
    // Groups that are kept, and whether with their spheres.
    let mut numbers: HashMap<(usize, bool), u32> = HashMap::new();
    let mut arranged = Arranged::default();
    let mut order = Vec::new();
    let mut number_of = |group: usize, is_whole: bool| {
        *numbers.entry((group, is_whole)).or_insert_with(|| {
            order.push((group, is_whole));
            order.len() as u32 - 1
        })
    };
    for (index, item) in items.drain(..).enumerate() {
        if let Some(motion) = moving.remove(&index) {
            let (group, name) = match item {
                Item::Instance(placed) => (placed.group, placed.name),
                Item::Shape(shape) => {
                    groups.push(vec![*shape]);
                    (groups.len() - 1, None)
                }
            };
            let index = arranged.motions.len() as u32;
            arranged.instances.push(Instance::moving(number_of(group, true), index, &motion));
            arranged.names.push(name);
            arranged.motions.push(motion);
            continue;
        }
        match (item, of_shape.get(&index)) {
            (Item::Shape(shape), Some(&group)) => {
                arranged.instances.push(Instance::new(number_of(group, false), &shape.common.to_world));
                arranged.names.push(Some(shape.name));
            }
            (Item::Shape(shape), None) => arranged.shapes.push(*shape),
            (Item::Instance(placed), _) => {
                let is_kept = !is_copied[placed.group] && kept(0, &placed.to_world).is_some();
                let copies = groups[placed.group].iter().filter(|shape| !is_kept || is_sphere(shape));
                arranged.shapes.extend(copies.map(|shape| copy(shape, &placed)));
                if arranged.shapes.len() > MAX_SHAPES {
                    let message = format!("more than {MAX_SHAPES} shapes, including the shapes of instances");
                    return Err(placed.origin.error(message));
                }
                if is_kept {
                    arranged.instances.push(Instance::new(number_of(placed.group, false), &placed.to_world));
                    arranged.names.push(placed.name);
                }
            }
        }
    }
    for (group, is_whole) in order {
        arranged.groups.push(arranged.shapes.len());
        arranged.shapes.extend(groups[group].iter().filter(|shape| is_whole || !is_sphere(shape)).cloned());
    }
    Ok(arranged)
}

/// Motions of items by their indices, while the shutter is open. Items that do not move in this time get their place.
fn moving(items: &mut [Item], shutter: [f64; 2]) -> Result<HashMap<usize, Motion>> {
    let mut motions = HashMap::new();
    for (index, item) in items.iter_mut().enumerate() {
        let keys = match item {
            Item::Shape(shape) => shape.keys.take(),
            Item::Instance(placed) => placed.keys.take(),
        };
        let Some(mut keys) = keys else { continue };
        // A mirror is a part of a shape. Where a mesh gives no normals, its fronts are then those of a shape that stands.
        let is_mirrored = matches!(item, Item::Shape(_)) && keys.first().is_some_and(|(_, key)| is_mirrored(key));
        let mirror = DMat4::from_scale(DVec3::new(if is_mirrored { -1.0 } else { 1.0 }, 1.0, 1.0));
        keys.iter_mut().for_each(|(_, matrix)| *matrix *= mirror);
        let course = Motion::of_keys(&keys, shutter);
        let origin = match item {
            Item::Shape(shape) => &shape.origin,
            Item::Instance(placed) => placed.origin,
        };
        let course = course.map_err(|message| origin.error(format!("its motion: {message}")))?;
        match (course, item) {
            (Course::Still(matrix), Item::Shape(shape)) => {
                shape.common.to_world = matrix * mirror * shape.common.to_world;
            }
            (Course::Still(matrix), Item::Instance(placed)) => placed.to_world = matrix,
            (Course::Moving(motion), item) => {
                if let Item::Shape(shape) = item {
                    shape.common.to_world = mirror * shape.common.to_world;
                }
                motions.insert(index, motion);
            }
        }
    }
    Ok(motions)
}

/// Whether each group becomes copies. Those that add the fewest primitives do, as long as all copies together add at most [`MOST_COPIED`].
/// A copy of a single primitive is as small as an instance.
fn copied(primitives: &[u64], instances: &[u64]) -> Vec<bool> {
    let added = |group: usize| {
        let (primitives, instances) = (u128::from(primitives[group]), u128::from(instances[group]));
        u64::try_from((primitives * instances).saturating_sub(primitives + instances)).unwrap_or(u64::MAX)
    };
    let mut order: Vec<usize> = (0..primitives.len()).collect();
    order.sort_by_key(|&group| added(group));
    let mut sum = 0_u64;
    let mut copied = vec![false; primitives.len()];
    for group in order {
        sum = sum.saturating_add(added(group));
        copied[group] = sum <= MOST_COPIED;
    }
    copied
}

/// The instance of a group; `None` where its transform has no inverse that is good enough.
fn kept(group: u32, to_world: &DMat4) -> Option<Instance> {
    Some(Instance::new(group, to_world)).filter(|instance| instance.group_from_world().is_some())
}

fn is_sphere(shape: &Shape) -> bool {
    matches!(shape.geometry, Geometry::Sphere | Geometry::FacingDisk)
}

/// Copy of a group's shape in the place of an instance.
fn copy(shape: &Shape, placed: &Placed) -> Shape {
    let common = Common { instance_to_world: placed.to_world, ..shape.common };
    let name = Arc::clone(placed.name.as_ref().unwrap_or(&shape.name));
    Shape { geometry: shape.geometry.clone(), common, name, origin: placed.origin.clone(), keys: None }
}

/// Shape of the items in the space of its mesh.
fn in_mesh_space(items: &[Item], index: usize) -> Shape {
    match &items[index] {
        Item::Shape(shape) => {
            let common = Common { to_world: DMat4::IDENTITY, ..shape.common };
            Shape { common, ..Shape::clone(shape) }
        }
        Item::Instance(_) => unreachable!("only shapes share a mesh"),
    }
}

/// Indices of shapes that differ in nothing but their place, two or more each.
fn shared_meshes(
    items: &[Item],
    moving: &HashMap<usize, Motion>,
    meshes: &HashMap<MeshFile, Arc<Mesh>>,
) -> Vec<Vec<usize>> {
    let has_normals: HashMap<&MeshFile, bool> = meshes.iter().map(|(file, mesh)| (file, has_normals(mesh))).collect();
    let mut users: HashMap<_, Vec<usize>> = HashMap::new();
    let mut order = Vec::new();
    for (index, item) in items.iter().enumerate() {
        let Item::Shape(shape) = item else { continue };
        let Shape { geometry: Geometry::Mesh(file, options), common, .. } = &**shape else { continue };
        let has_normals = !options.face_normals && has_normals.get(file).is_some_and(|&has| has);
        if moving.contains_key(&index) || !can_be_shared(options, common, has_normals) {
            continue;
        }
        let MeshOptions { face_normals, flip_uvs } = *options;
        let key =
            (file, face_normals, flip_uvs, common.flip_normals, common.front_only, common.unseen, common.material);
        let indices = users.entry(key).or_default();
        if indices.is_empty() {
            order.push(key);
        }
        indices.push(index);
    }
    order.into_iter().filter_map(|key| users.remove(&key)).filter(|indices| indices.len() > 1).collect()
}

/// Number of sets of vertices of a mesh that changes its shape, else 0.
fn set_count(shape: &Shape, meshes: &HashMap<MeshFile, Arc<Mesh>>) -> u64 {
    let Geometry::Mesh(file, _) = &shape.geometry else { return 0 };
    let later = meshes.get(file).map_or(0, |mesh| mesh.later_sets().len());
    if later > 0 { later as u64 + 1 } else { 0 }
}

/// Whether the file gives a normal for each vertex, at all times.
fn has_normals(mesh: &Mesh) -> bool {
    let are_given = |normals: &[Vec3]| !normals.is_empty() && normals.iter().all(|normal| *normal != Vec3::ZERO);
    are_given(&mesh.normals) && mesh.later_sets().iter().all(|set| are_given(set.normals))
}

/// Whether an instance of the mesh shows what the shape is. An emitter is a light of its own. Where the file gives no normals, an
/// instance that is mirrored has other fronts than a mirrored shape, and normals that are computed from the angles of triangles change
/// with the transform.
fn can_be_shared(options: &MeshOptions, common: &Common, has_normals: bool) -> bool {
    let is_even = || options.face_normals || is_similarity(&common.to_world, SIMILARITY);
    let is_same = has_normals || (!is_mirrored(&common.to_world) && is_even());
    common.emitter.is_none() && is_same && kept(0, &common.to_world).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_groups_are_copied_as_long_as_there_is_room() {
        let half = MOST_COPIED / 2;
        // A group that is shown once, or whose copies are as small as instances, adds nothing.
        assert_eq!(copied(&[1 << 24, 1, 2], &[1, 1 << 24, 2]), [true; 3]);
        // 2 + n primitives in two places add n of them.
        assert_eq!(copied(&[half + 2, half + 2], &[2, 2]), [true, true]);
        assert_eq!(copied(&[half + 3, half + 2], &[2, 2]), [false, true]);
        assert_eq!(copied(&[u64::MAX, 10], &[u64::MAX, 10]), [false, true]);
    }
}
