//! Instances as the hierarchy holds them: their records and boxes, and the groups that they show.

use std::ops::Range;

use glam::{DMat3, DVec3, Vec3};
use obvhs::aabb::Aabb;

use crate::generated::constants;
use crate::generated::layout::{AttributeRecord, InstanceRecord, MovingRecord, PlacementRecord, PrimitiveRecord};
use crate::scene::{Instance, Motion};

/// Levels of a group's wide nodes whose boxes are placed to find an instance's box: the box of a whole group would grow by its
/// rotation.
const PLACED_LEVELS: u32 = 2;
/// Steps of a motion's segment whose boxes are placed.
const SWEPT_STEPS: u32 = 32;
/// Most that a matrix errs which kernels compute from a motion, as a share of the distances.
const MOVING_ERROR: f64 = 1.0e-5;
/// Most that the matrices of an instance err, against each other and by rounding, as a share of their terms.
const MATRIX_ERROR: f64 = 1.0e-6;

/// Group that instances show, as a part of the hierarchy.
pub struct Part {
    /// Index of the root among the nodes.
    pub root: u32,
    /// The primitives, which are in the group's space.
    pub primitives: Range<u32>,
    /// Boxes that together hold the group, as (minimum, maximum).
    pub boxes: Vec<(Vec3, Vec3)>,
}

/// Box of an instance whose group lies in `boxes`. It reaches beyond them by what roundings of the transform move a point.
pub(super) fn placed_box(instance: &Instance, boxes: &[(Vec3, Vec3)]) -> Aabb {
    let origin = instance.origin.as_dvec3();
    let placed = boxes.iter().map(|&of_group| instance.place_box(of_group));
    let (low, high) = placed.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((origin, origin));
    let reach = (low - origin).abs().max((high - origin).abs());
    let terms = instance.world_from_group().abs() * (inverse(instance).abs() * reach);
    let margin = MATRIX_ERROR * (terms + origin.abs());
    Aabb::new((low - margin).as_vec3().into(), (high + margin).as_vec3().into())
}

/// Box that holds a group which lies in `boxes` at all times of a motion.
pub(super) fn swept_box(motion: &Motion, boxes: &[(Vec3, Vec3)]) -> Aabb {
    let swept = boxes.iter().flat_map(|&of_group| motion.swept(of_group, SWEPT_STEPS));
    let origin = motion.at(0.0).w_axis.truncate();
    let (low, high) = swept.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((origin, origin));
    let times = (0..=SWEPT_STEPS).map(|i| f64::from(i) / f64::from(SWEPT_STEPS));
    let origins: Vec<DVec3> = times
        .flat_map(|s| motion.segments().iter().map(move |own| own.origin.as_dvec3() + s * own.travel.as_dvec3()))
        .collect();
    let farthest = origins.iter().map(|origin| origin.abs()).fold(DVec3::ZERO, DVec3::max);
    let reach = origins.iter().map(|origin| (low - *origin).abs().max((high - *origin).abs()));
    let reach = reach.fold(DVec3::ZERO, DVec3::max).length();
    let margin = MOVING_ERROR * (reach + farthest);
    Aabb::new((low - margin).as_vec3().into(), (high + margin).as_vec3().into())
}

fn inverse(instance: &Instance) -> DMat3 {
    instance.group_from_world().unwrap_or(DMat3::ZERO)
}

/// Records of an instance of the group whose hierarchy begins at the node `root`.
pub(super) fn instance_records(instance: &Instance, root: u32) -> (PrimitiveRecord, AttributeRecord) {
    let local = inverse(instance);
    let [local_x, local_y, local_z] = [0, 1, 2].map(|row| local.row(row).as_vec3().to_array());
    let unmoved = if instance.is_identity() { constants::PRIMITIVE_UNMOVED } else { 0 };
    let flags = constants::PRIMITIVE_INSTANCE | unmoved;
    let record = InstanceRecord { local_x, flags, local_y, root, local_z, first_light: 0 };
    (bytemuck::cast(record), placement(instance))
}

/// Records of an instance that moves by the motion at `motion`: its first texel and its number of segments.
pub(super) fn moving_records(instance: &Instance, root: u32, motion: [u32; 2]) -> (PrimitiveRecord, AttributeRecord) {
    let [motion, segments] = motion;
    let flags = constants::PRIMITIVE_INSTANCE | constants::PRIMITIVE_MOVING;
    let record = MovingRecord { motion, segments, flags, root, ..bytemuck::Zeroable::zeroed() };
    (bytemuck::cast(record), placement(instance))
}

/// Place of an instance. Kernels do not read that of one that moves.
fn placement(instance: &Instance) -> AttributeRecord {
    let [world_x, world_y, world_z] = instance.axes.map(Vec3::into);
    let [origin_x, origin_y, origin_z] = instance.origin.into();
    bytemuck::cast(PlacementRecord { world_x, origin_x, world_y, origin_y, world_z, origin_z })
}

/// Whether the record of a primitive is that of an instance.
pub(crate) fn is_instance(record: &PrimitiveRecord) -> bool {
    record.flags & constants::PRIMITIVE_INSTANCE != 0
}

/// Part that the instance of a record shows.
pub(crate) fn part_of<'a>(parts: &'a [Part], instance: &PrimitiveRecord) -> &'a Part {
    &parts[number_of_part(parts, instance)]
}

/// Index of the part that the instance of a record shows.
pub(crate) fn number_of_part(parts: &[Part], instance: &PrimitiveRecord) -> usize {
    let InstanceRecord { root, .. } = bytemuck::cast(*instance);
    parts.partition_point(|part| part.root < root)
}

/// First texel of the motion of the instance of a record, if it moves.
pub(crate) fn motion_of(instance: &PrimitiveRecord) -> Option<u32> {
    let MovingRecord { motion, flags, .. } = bytemuck::cast(*instance);
    (flags & constants::PRIMITIVE_MOVING != 0).then_some(motion)
}

/// The primitive of a group as the instance shows it, without the distance of its plane.
pub(crate) fn shown(record: &PrimitiveRecord, placement: &AttributeRecord) -> PrimitiveRecord {
    let PlacementRecord { world_x, origin_x, world_y, origin_y, world_z, origin_z } = bytemuck::cast(*placement);
    let matrix = DMat3::from_cols_array_2d(&[world_x, world_y, world_z].map(|axis| axis.map(f64::from)));
    let origin = DVec3::from([origin_x, origin_y, origin_z].map(f64::from));
    let turned = |vector: [f32; 3]| matrix * Vec3::from(vector).as_dvec3();
    PrimitiveRecord {
        origin: (origin + turned(record.origin)).as_vec3().into(),
        edge_u: turned(record.edge_u).as_vec3().into(),
        edge_v: turned(record.edge_v).as_vec3().into(),
        ..*record
    }
}

/// The instance that a placement describes, without its group.
pub(crate) fn placed(placement: &AttributeRecord) -> Instance {
    let PlacementRecord { world_x, origin_x, world_y, origin_y, world_z, origin_z } = bytemuck::cast(*placement);
    let axes = [world_x, world_y, world_z].map(Vec3::from);
    Instance { group: 0, axes, origin: Vec3::new(origin_x, origin_y, origin_z), motion: None }
}

/// Boxes of a group, in its space: those of the children in the first levels of its nodes.
pub(super) fn boxes<const WORDS: usize>(nodes: &[[u32; WORDS]]) -> Vec<(Vec3, Vec3)> {
    let mut boxes = Vec::new();
    let mut pending = vec![(0_usize, 1)];
    while let Some((index, level)) = pending.pop() {
        let node = &nodes[index];
        let bytes: &[u8] = bytemuck::cast_slice(node);
        let (cells, metas, planes) = (&bytes[12..15], &bytes[24..32], &bytes[32..]);
        let mut inner = node[4] as usize;
        for slot in (0..8).filter(|&slot| metas[slot] != 0) {
            let is_inner = bytes[15] & (1 << slot) != 0;
            if is_inner && level < PLACED_LEVELS {
                pending.push((inner, level + 1));
            } else {
                let plane = |axis: usize, at: usize| {
                    let cell = f32::from_bits(u32::from(cells[axis]) << 23);
                    f32::from_bits(node[axis]) + cell * f32::from(planes[16 * axis + at + slot])
                };
                boxes.push((
                    Vec3::from([0, 1, 2].map(|axis| plane(axis, 0))),
                    Vec3::from([0, 1, 2].map(|axis| plane(axis, 8))),
                ));
            }
            inner += usize::from(is_inner);
        }
    }
    boxes
}
