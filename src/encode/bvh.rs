//! Bounding volume hierarchy, and geometry laid out for the kernels. Only this module and its children name `obvhs`.

mod deforming;
pub(crate) mod instances;
mod motions;
mod normals;
mod plane;
mod split;
mod turn;
mod wide;

use glam::Vec3;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use self::deforming::{KEY_TEXELS, Keys, move_keys, vertices_of};
use self::instances::is_instance;
use self::normals::octahedral_encode;
use self::split::Boxes;
use self::turn::Turn;
use crate::generated::constants;
use crate::generated::layout::{AttributeRecord, InstanceRecord, KeyRecord, PrimitiveRecord, TEXEL_BYTES};
use crate::scene::deformation::Deformation;
use crate::scene::{Group, Instance, Primitive, PrimitiveShape, Scene};

pub(crate) use self::deforming::is_deforming;
pub use self::instances::Part;
pub use self::motions::Motions;

/// Number of words of one compressed wide node (Ylitie et al. 2017).
pub const NODE_WORDS: usize = constants::NODE_TEXELS as usize * TEXEL_BYTES / size_of::<u32>();

/// Texels of a primitive.
const PRIMITIVE_TEXELS: usize = size_of::<PrimitiveRecord>() / TEXEL_BYTES;

/// Margin of a box as a share of the largest coordinate of its primitive, whose bounds are rounded.
const BOX_MARGIN: f32 = 1.0e-6;

/// Hierarchy over primitives, with the attributes that shading needs.
pub struct Bvh {
    /// Compressed wide nodes; at least one. Those of the world come first, then those of each part.
    pub nodes: Vec<[u32; NODE_WORDS]>,
    /// Primitives in the order of the leaves. A triangle that was split into several boxes occurs several times. An instance
    /// is one of them, with an [`InstanceRecord`](crate::generated::layout::InstanceRecord) in place of its own.
    pub primitives: Vec<PrimitiveRecord>,
    /// Shading attributes, in the order of `primitives`; of an instance, its
    /// [`PlacementRecord`](crate::generated::layout::PlacementRecord).
    pub attributes: Vec<AttributeRecord>,
    /// Index in the scene of each of `primitives`. Instances are numbered after the scene's primitives, and then the primitives of each
    /// group.
    pub sources: Vec<u32>,
    /// Number of nodes on the longest way from the root to a leaf; a traversal stack needs one entry fewer.
    pub depth: u32,
    /// Lower and upper corner of all primitives; a unit box at the origin where there are none.
    pub bounds: (Vec3, Vec3),
    /// Groups that instances show.
    pub parts: Vec<Part>,
    /// Keys of triangles that deform. They follow the primitives on the device, and the motions follow them.
    pub keys: Vec<KeyRecord>,
    /// Motions of instances, and that of the camera.
    pub motions: Motions,
}

impl Bvh {
    /// Builds the hierarchy over any number of primitives of any shape and size. All their numbers must be finite.
    pub fn build(primitives: &[Primitive]) -> Self {
        Self::build_deforming(primitives, &[])
    }

    /// Builds the hierarchy over primitives of which some deform.
    pub fn build_deforming(primitives: &[Primitive], deformations: &[Deformation]) -> Self {
        let mut bvh = Self::build_with_own_keys(primitives, deformations);
        let texels = bvh.primitives.len() * PRIMITIVE_TEXELS;
        move_keys(&mut bvh.primitives, texels);
        bvh
    }

    /// The hierarchy whose triangles count their keys from the first of all keys.
    fn build_with_own_keys(primitives: &[Primitive], deformations: &[Deformation]) -> Self {
        let bounds = scene_bounds(primitives, deformations);
        let (nodes, order) = match primitives {
            [] => (vec![[0; NODE_WORDS]], Vec::new()),
            _ => build_nodes(Boxes::new(primitives, deformations, Vec::new(), BOX_MARGIN)),
        };
        let keys = Keys::new(deformations, |index| Turn::of(&primitives[index as usize]));
        let records = order.par_iter().map(|&index| {
            let (mut record, attributes) = records(&primitives[index as usize]);
            keys.mark(&mut record, index);
            (record, attributes)
        });
        let (primitives, mut attributes): (_, Vec<_>) = records.unzip();
        let depth = depth(&nodes);
        number_lights(attributes.iter_mut());
        let (parts, keys, motions) = (Vec::new(), keys.records, Motions::default());
        Self { primitives, attributes, sources: order, nodes, depth, bounds, parts, keys, motions }
    }

    /// Builds the hierarchy of a scene. All numbers must be finite, and all transforms of instances must have an inverse.
    pub fn of_scene(scene: &Scene) -> Self {
        let mut bvh = match scene.instances.is_empty() {
            true => Self::build_deforming(&scene.primitives, &scene.deformations),
            false => with_instances(scene),
        };
        if let Some(motion) = &scene.camera_motion {
            bvh.motions.add_camera(motion, bvh.primitives.len() + bvh.keys.len());
        }
        bvh
    }

    /// Whether some primitives are instances.
    pub fn has_instances(&self) -> bool {
        !self.parts.is_empty()
    }

    /// Number of instances.
    pub fn instance_count(&self) -> usize {
        if self.has_instances() { self.primitives.iter().filter(|record| is_instance(record)).count() } else { 0 }
    }

    /// Primitives that are no instances, with their indices and attributes; those of groups are in the space of their group.
    pub fn surfaces(&self) -> impl Iterator<Item = (u32, &PrimitiveRecord, &AttributeRecord)> {
        let all = (0..).zip(self.primitives.iter().zip(&self.attributes));
        all.filter(|(_, (record, _))| !is_instance(record))
            .map(|(index, (record, attributes))| (index, record, attributes))
    }

    /// Whether any primitive is a sphere.
    pub fn has_spheres(&self) -> bool {
        self.primitives.iter().any(|p| p.flags & constants::PRIMITIVE_SHAPE_MASK == constants::SHAPE_SPHERE)
    }

    /// Whether any primitive is a disk that faces what it lights.
    pub fn has_facing_disks(&self) -> bool {
        self.surfaces().any(|(_, record, _)| record.flags & constants::PRIMITIVE_FACING != 0)
    }

    /// Whether instances show any sphere.
    pub fn has_placed_spheres(&self) -> bool {
        let is_sphere = |p: &PrimitiveRecord| p.flags & constants::PRIMITIVE_SHAPE_MASK == constants::SHAPE_SPHERE;
        self.parts.first().is_some_and(|first| self.primitives[first.primitives.start as usize..].iter().any(is_sphere))
    }

    /// Whether the vertices of some triangle move.
    pub fn deforms(&self) -> bool {
        !self.keys.is_empty()
    }

    /// Vertices of a triangle that deforms, at all times.
    pub(crate) fn deforming_vertices(&self, record: &PrimitiveRecord) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        vertices_of(record, &self.keys, self.primitives.len() * PRIMITIVE_TEXELS)
    }

    /// Number of leaves of the world, which come first among the primitives.
    pub fn world_len(&self) -> usize {
        self.parts.first().map_or(self.primitives.len(), |part| part.primitives.start as usize)
    }

    /// Whether any sphere emits light.
    pub fn has_emitting_spheres(&self) -> bool {
        let is_sphere = |flags: u32| flags & constants::PRIMITIVE_SHAPE_MASK == constants::SHAPE_SPHERE;
        self.primitives.iter().zip(&self.attributes).any(|(p, a)| is_sphere(p.flags) && a.light != constants::NONE)
    }

    /// Whether any primitive has normals at its vertices.
    pub fn has_vertex_normals(&self) -> bool {
        self.primitives.iter().any(|p| p.flags & constants::PRIMITIVE_VERTEX_NORMALS != 0)
    }

    /// Whether any primitive lets rays pass that meet it from behind.
    pub fn has_front_only(&self) -> bool {
        self.primitives.iter().any(|p| p.flags & constants::PRIMITIVE_FRONT_ONLY != 0)
    }

    /// Whether the camera does not see some primitive, other than disks that face what they light.
    pub fn has_unseen(&self) -> bool {
        let mask = constants::PRIMITIVE_UNSEEN | constants::PRIMITIVE_FACING;
        self.surfaces().any(|(_, record, _)| record.flags & mask == constants::PRIMITIVE_UNSEEN)
    }

    /// Largest absolute coordinate of the scene. Rounding errors of positions are proportional to it.
    pub fn largest_coordinate(&self) -> f32 {
        largest_coordinate(self.bounds)
    }
}

/// Nodes, and the primitives' indices in the order of the leaves.
fn build_nodes(boxes: Boxes) -> (Vec<[u32; NODE_WORDS]>, Vec<u32>) {
    let wide = wide::build(boxes);
    (bytemuck::cast_vec(wide.nodes), wide.order)
}

/// Records of a primitive.
fn records(primitive: &Primitive) -> (PrimitiveRecord, AttributeRecord) {
    let primitive = widest_corner_first(primitive);
    (primitive_record(&primitive), attribute_record(&primitive))
}

/// Hierarchy of two levels: that of the world has instances among its leaves, and each group has one of its own.
fn with_instances(scene: &Scene) -> Bvh {
    let Scene { primitives, deformations, groups, instances: placements, motions, .. } = scene;
    let of_group = |group: &Group| Bvh::build_with_own_keys(&group.primitives, &group.deformations);
    let of_groups: Vec<Bvh> = groups.par_iter().map(of_group).collect();
    let boxes_of_groups: Vec<_> = of_groups.iter().map(|bvh| instances::boxes(&bvh.nodes)).collect();
    let place = |instance: &Instance| {
        let boxes = &boxes_of_groups[instance.group as usize];
        match instance.motion {
            Some(motion) => instances::swept_box(&motions[motion as usize], boxes),
            None => instances::placed_box(instance, boxes),
        }
    };
    let placed: Vec<Aabb> = placements.par_iter().map(place).collect();
    let union = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
    let shown = placed.iter().map(|aabb| (Vec3::from(aabb.min), Vec3::from(aabb.max)));
    let own = (!primitives.is_empty()).then(|| scene_bounds(primitives, deformations));
    let bounds = own.into_iter().chain(shown).reduce(union).unwrap_or((Vec3::ZERO, Vec3::ONE));
    let (mut nodes, order) = build_nodes(Boxes::new(primitives, deformations, placed, BOX_MARGIN));

    // The parts follow the world.
    let mut parts = Vec::with_capacity(groups.len());
    let (mut root, mut first) = (nodes.len() as u32, order.len() as u32);
    for (bvh, boxes) in of_groups.iter().zip(boxes_of_groups) {
        let end = first + bvh.primitives.len() as u32;
        parts.push(Part { root, primitives: first..end, boxes });
        (root, first) = (root + bvh.nodes.len() as u32, end);
    }
    let all_primitives = first as usize;
    let own_keys = Keys::new(deformations, |index| Turn::of(&primitives[index as usize]));
    let all_keys = own_keys.records.len() + of_groups.iter().map(|bvh| bvh.keys.len()).sum::<usize>();
    let of_motions = Motions::new(motions, all_primitives + all_keys);
    let of_leaf = |&index: &u32| match primitives.get(index as usize) {
        Some(primitive) => {
            let (mut record, attributes) = records(primitive);
            own_keys.mark(&mut record, index);
            (record, attributes)
        }
        None => {
            let instance = &placements[index as usize - primitives.len()];
            let root = parts[instance.group as usize].root;
            match instance.motion {
                Some(motion) => instances::moving_records(instance, root, of_motions.place(motion)),
                None => instances::instance_records(instance, root),
            }
        }
    };
    let (mut all, mut attributes): (Vec<_>, Vec<_>) = order.par_iter().map(of_leaf).unzip();
    number_lights_of_world(&mut all, &mut attributes, &parts, &of_groups);
    let mut keys = own_keys.records;
    move_keys(&mut all, all_primitives * PRIMITIVE_TEXELS);
    let mut sources = order;
    let mut first_source = (primitives.len() + placements.len()) as u32;
    let mut deepest = 0;
    let depth_of_world = depth(&nodes);
    for ((bvh, part), group) in of_groups.into_iter().zip(&parts).zip(groups) {
        nodes.extend(bvh.nodes.iter().map(|node| moved(*node, part)));
        let first_of_part = all.len();
        all.extend(bvh.primitives);
        move_keys(&mut all[first_of_part..], all_primitives * PRIMITIVE_TEXELS + keys.len() * KEY_TEXELS);
        keys.extend(bvh.keys);
        attributes.extend(bvh.attributes);
        sources.extend(bvh.sources.iter().map(|source| first_source + source));
        first_source += group.primitives.len() as u32;
        deepest = deepest.max(bvh.depth);
    }
    let depth = depth_of_world + deepest;
    Bvh { nodes, primitives: all, attributes, sources, depth, bounds, parts, keys, motions: of_motions }
}

/// Node of a group's hierarchy as a node of the whole one.
fn moved(mut node: [u32; NODE_WORDS], part: &Part) -> [u32; NODE_WORDS] {
    node[4] += part.root;
    node[5] += part.primitives.start;
    node
}

fn scene_bounds(primitives: &[Primitive], deformations: &[Deformation]) -> (Vec3, Vec3) {
    let union = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
    let still = primitives.par_iter().map(Primitive::bounds).reduce_with(union).unwrap_or((Vec3::ZERO, Vec3::ONE));
    deformations.iter().flat_map(Deformation::boxes).map(|(_, of_key)| of_key).fold(still, union)
}

fn largest_coordinate(bounds: (Vec3, Vec3)) -> f32 {
    bounds.0.abs().max(bounds.1.abs()).max_element()
}

/// Number of nodes on the longest way down, found through the children's indices in the nodes.
fn depth(nodes: &[[u32; NODE_WORDS]]) -> u32 {
    let mut deepest = 1;
    let mut pending = vec![(0_u32, 1_u32)];
    while let Some((index, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        let node = &nodes[index as usize];
        let inner_count = (node[3] >> 24).count_ones();
        pending.extend((0..inner_count).map(|child| (node[4] + child, depth + 1)));
    }
    deepest
}

/// Reorders a triangle to begin at the vertex opposite its longest edge.
fn widest_corner_first(p: &Primitive) -> Primitive {
    let turn = Turn::of(p);
    let [origin, edge_u, edge_v] = turn.triangle(p.origin, p.edge_u, p.edge_v);
    let mut turned = Primitive { origin, edge_u, edge_v, ..*p };
    turn.corners(&mut turned.uvs);
    turned.normals.iter_mut().for_each(|normals| turn.corners(normals));
    turned
}

fn primitive_record(p: &Primitive) -> PrimitiveRecord {
    let shape = match p.shape {
        PrimitiveShape::Triangle => constants::SHAPE_TRIANGLE,
        PrimitiveShape::Parallelogram => constants::SHAPE_PARALLELOGRAM,
        PrimitiveShape::Disk => constants::SHAPE_DISK,
        PrimitiveShape::Sphere => constants::SHAPE_SPHERE,
        PrimitiveShape::FacingDisk => constants::SHAPE_SPHERE | constants::PRIMITIVE_FACING,
    };
    let flip = if p.flip_normal { constants::PRIMITIVE_FLIP_NORMAL } else { 0 };
    let normals = if p.normals.is_some() { constants::PRIMITIVE_VERTEX_NORMALS } else { 0 };
    let front_only = p.front_only && !p.shape.is_round();
    let front_only = if front_only { constants::PRIMITIVE_FRONT_ONLY } else { 0 };
    let unseen = if p.unseen { constants::PRIMITIVE_UNSEEN } else { 0 };
    let longest = match p.shape {
        PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => p.edge_u.length(),
        _ => p.edge_u.length().max(p.edge_v.length()).max((p.edge_u - p.edge_v).length()),
    };
    let (plane, large) = plane::equation(p, longest);
    let large = if large { constants::PRIMITIVE_LARGE } else { 0 };
    PrimitiveRecord {
        origin: p.origin.into(),
        flags: shape | flip | normals | large | front_only | unseen,
        edge_u: p.edge_u.into(),
        edge_tolerance: longest,
        edge_v: p.edge_v.into(),
        plane,
    }
}

fn attribute_record(p: &Primitive) -> AttributeRecord {
    AttributeRecord {
        normals: p.normals.map_or([0; 3], |normals| normals.map(octahedral_encode)),
        material: p.material,
        uv0: p.uvs[0].into(),
        uv1: p.uvs[1].into(),
        uv2: p.uvs[2].into(),
        emitter: p.emitter.unwrap_or(constants::NONE),
        light: constants::NONE,
    }
}

/// Numbers the emitting primitives in the order of the leaves. Each is a light of its own.
fn number_lights<'a>(attributes: impl Iterator<Item = &'a mut AttributeRecord>) {
    let emitting = attributes.filter(|attributes| attributes.emitter != constants::NONE);
    emitting.zip(0..).for_each(|(attributes, light)| attributes.light = light);
}

/// Numbers the lights of the world and of instances in the order of the leaves. The lights of a group follow each other in each of its
/// instances.
fn number_lights_of_world(
    records: &mut [PrimitiveRecord],
    attributes: &mut [AttributeRecord],
    parts: &[Part],
    groups: &[Bvh],
) {
    let is_light = |attributes: &&AttributeRecord| attributes.light != constants::NONE;
    let counts: Vec<u32> = groups.iter().map(|bvh| bvh.attributes.iter().filter(is_light).count() as u32).collect();
    let mut next = 0;
    for (record, own) in records.iter_mut().zip(attributes) {
        if is_instance(record) {
            let group = instances::number_of_part(parts, record);
            let instance: &mut InstanceRecord = bytemuck::cast_mut(record);
            instance.first_light = next;
            next += counts[group];
        } else if own.emitter != constants::NONE {
            own.light = next;
            next += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    fn triangle(at: Vec3, size: f32) -> Primitive {
        Primitive {
            shape: PrimitiveShape::Triangle,
            origin: at,
            edge_u: vec3(size, 0.0, 0.0),
            edge_v: vec3(0.0, size, 0.0),
            normals: None,
            uvs: Default::default(),
            flip_normal: false,
            front_only: false,
            unseen: false,
            material: 0,
            emitter: None,
        }
    }

    #[test]
    fn no_one_and_degenerate_primitives_do_no_harm() {
        assert_eq!(Bvh::build(&[]).nodes.len(), 1);
        assert_eq!(Bvh::build(&[triangle(Vec3::ZERO, 1.0)]).primitives.len(), 1);
        assert_eq!(Bvh::build(&[triangle(Vec3::ONE, 0.0); 100]).primitives.len(), 100);
    }

    #[test]
    fn triangles_begin_at_their_widest_corner() {
        let vertices = [vec3(1.0, 2.0, 0.0), vec3(5.0, 2.0, 0.0), vec3(5.0, 2.25, 0.0)];
        for by in 0..3 {
            let mut turned = vertices;
            turned.rotate_left(by);
            let [a, b, c] = turned;
            let uvs = turned.map(|vertex| vertex.truncate());
            let p = Primitive { origin: a, edge_u: b - a, edge_v: c - a, uvs, ..triangle(a, 1.0) };
            let p = widest_corner_first(&Primitive { normals: Some(turned), ..p });
            let expected = [vertices[1], vertices[2], vertices[0]];
            assert_eq!([p.origin, p.origin + p.edge_u, p.origin + p.edge_v], expected);
            assert_eq!(p.normals, Some(expected));
            assert_eq!(p.uvs, expected.map(|vertex| vertex.truncate()));
        }
    }

    /// Collects all primitives below a node. Each must lie within the node's quantized boxes on the way down.
    fn below(bvh: &Bvh, index: usize, found: &mut Vec<usize>) {
        let node = &bvh.nodes[index];
        let bytes: &[u8] = bytemuck::cast_slice(node);
        let (cells, metas, planes) = (&bytes[12..15], &bytes[24..32], &bytes[32..]);
        let mut inner = node[4] as usize;
        for (slot, &meta) in metas.iter().enumerate().filter(|(_, meta)| **meta != 0) {
            let mut own = Vec::new();
            if bytes[15] & (1 << slot) != 0 {
                assert_eq!(meta, 0x20 | (24 + slot as u8));
                below(bvh, inner, &mut own);
                inner += 1;
            } else {
                let first = node[5] as usize + usize::from(meta & 31);
                own.extend(first..first + (meta >> 5).count_ones() as usize);
            }
            for axis in 0..3 {
                let cell = f32::from_bits(u32::from(cells[axis]) << 23);
                let plane = |at: usize| f32::from_bits(node[axis]) + cell * f32::from(planes[16 * axis + at + slot]);
                let is_inside = |i: &usize| {
                    bvh.primitives[*i].origin[axis] >= plane(0) && bvh.primitives[*i].origin[axis] <= plane(8)
                };
                assert!(own.iter().all(is_inside));
            }
            found.extend(own);
        }
    }

    #[test]
    fn every_primitive_lies_in_some_leaf() {
        // One primitive; few; and so many that subtrees are built apart, with a few large ones among them.
        for count in [1, 1000, 60_000] {
            let place = |i: u32| vec3((i % 251) as f32, (i * 7 % 13) as f32, (i / 251) as f32);
            let size = |i: u32| if i.is_multiple_of(997) { 100.0 } else { 0.5 };
            let primitives: Vec<_> =
                (0..count).map(|i| Primitive { material: i, ..triangle(place(i), size(i)) }).collect();
            let bvh = Bvh::build(&primitives);
            let mut found = Vec::new();
            below(&bvh, 0, &mut found);
            found.sort_unstable();
            assert_eq!(found, (0..count as usize).collect::<Vec<_>>());
            let mut materials: Vec<_> = bvh.attributes.iter().map(|a| a.material).collect();
            materials.sort_unstable();
            assert_eq!(materials, (0..count).collect::<Vec<_>>());
            assert!(bvh.depth < 16, "depth {}", bvh.depth);
        }
    }
}
