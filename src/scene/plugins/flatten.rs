//! Conversion of shapes to world-space primitives.

use glam::{DMat4, DVec3, Vec2, Vec3};

use super::color_blocks::ColorBlocks;
use super::transform::{axes, is_mirrored, normal_matrix};
use crate::scene::deformation::DeformedTriangle;
use crate::scene::mesh::Mesh;
use crate::scene::{Primitive, PrimitiveShape};

/// Properties that all primitives of one shape share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Common {
    /// Transform to the world or, within a group, to the group.
    pub to_world: DMat4,
    /// Transform from the group to the world. Normals of meshes are computed in the group, as in Mitsuba, and then
    /// transformed.
    pub instance_to_world: DMat4,
    pub flip_normals: bool,
    /// Whether rays from behind pass.
    pub front_only: bool,
    /// Whether the camera's rays pass.
    pub unseen: bool,
    pub material: u32,
    pub emitter: Option<u32>,
    /// Blocks of the mesh in the image of vertex colors, whose coordinates then replace the mesh's own.
    pub colors: Option<ColorBlocks>,
}

/// Options of a mesh shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeshOptions {
    pub face_normals: bool,
    pub flip_uvs: bool,
}

/// Texture coordinates of a triangle that has none: its barycentric coordinates.
const BARYCENTRIC_UVS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// Square or disk in the xy plane, from -1 to 1, that faces `+z`.
pub(super) fn flat(shape: PrimitiveShape, common: &Common) -> Vec<Primitive> {
    oriented(shape, common, DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z).into_iter().collect()
}

/// Six faces of the cube from -1 to 1. Each is given by its center and the directions of u and v, so that textures lie
/// as in Mitsuba.
pub(super) fn cube(common: &Common) -> Vec<Primitive> {
    let [x, y, z] = DVec3::AXES;
    [(-y, z, x), (y, -x, -z), (x, y, -z), (z, y, x), (-x, y, z), (-z, -y, x)]
        .into_iter()
        .filter_map(|(outward, u, v)| oriented(PrimitiveShape::Parallelogram, common, outward, u, v, outward))
        .collect()
}

/// Flat shape given in object space with its normal; `None` if it has no area.
fn oriented(
    shape: PrimitiveShape,
    common: &Common,
    center: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
) -> Option<Primitive> {
    let edge_u = common.to_world.transform_vector3(u).as_vec3();
    let edge_v = common.to_world.transform_vector3(v).as_vec3();
    let left_handed = u.cross(v).dot(normal) < 0.0;
    // A mirror reverses the cross product but not the normal, which moves with its surface.
    let flip_normal = left_handed ^ is_mirrored(&common.to_world) ^ common.flip_normals;
    let origin = common.to_world.transform_point3(center).as_vec3();
    has_area(edge_u, edge_v).then(|| primitive(shape, common, origin, edge_u, edge_v, flip_normal))
}

/// Sphere that the unit sphere becomes; `to_world` must be a similarity.
pub(super) fn sphere(common: &Common) -> Primitive {
    let [x, _, z] = axes(&common.to_world);
    let mirrored = is_mirrored(&common.to_world);
    let flip_normal = common.flip_normals ^ mirrored;
    let center = common.to_world.w_axis.truncate().as_vec3();
    let handedness = if mirrored { -1.0 } else { 1.0 };
    let sphere = primitive(PrimitiveShape::Sphere, common, center, x.as_vec3(), z.as_vec3(), flip_normal);
    Primitive { uvs: [Vec2::splat(handedness); 3], ..sphere }
}

/// Disk of the radius of that sphere which faces what it lights.
pub(super) fn facing_disk(common: &Common) -> Primitive {
    Primitive { shape: PrimitiveShape::FacingDisk, flip_normal: false, ..sphere(common) }
}

fn primitive(
    shape: PrimitiveShape,
    common: &Common,
    origin: Vec3,
    edge_u: Vec3,
    edge_v: Vec3,
    flip_normal: bool,
) -> Primitive {
    let Common { front_only, unseen, material, emitter, .. } = *common;
    let (normals, uvs) = (None, BARYCENTRIC_UVS);
    Primitive { shape, origin, edge_u, edge_v, normals, uvs, flip_normal, front_only, unseen, material, emitter }
}

/// Copy of a group's primitive; `None` if the transform leaves it no area.
pub(super) fn instantiated(p: Primitive, instance_to_world: &DMat4) -> Option<Primitive> {
    let vector = |v: Vec3| instance_to_world.transform_vector3(v.as_dvec3()).as_vec3();
    let origin = instance_to_world.transform_point3(p.origin.as_dvec3()).as_vec3();
    let (edge_u, edge_v) = (vector(p.edge_u), vector(p.edge_v));
    // A sphere's normal depends on its center alone.
    let turns_over = !p.shape.is_round() && is_mirrored(instance_to_world);
    let flip_normal = p.flip_normal ^ turns_over;
    // The signs of a sphere's texture coordinates tell the hand of its frame, which a mirror changes.
    let is_other_hand = p.shape.is_round() && is_mirrored(instance_to_world);
    let uvs = if is_other_hand { p.uvs.map(|uv| -uv) } else { p.uvs };
    has_area(edge_u, edge_v).then_some(Primitive { origin, edge_u, edge_v, flip_normal, uvs, ..p })
}

/// Mesh placed in the world, whose triangles are made one by one. Triangles without area are left out.
pub(super) struct PlacedMesh<'a> {
    mesh: &'a Mesh,
    flip_uvs: bool,
    common: Common,
    /// The vertices, where the shutter opens.
    first: Vertices,
    /// The vertices at evenly spaced times after that, where the mesh changes its shape.
    later: Vec<Vertices>,
    /// Indices of the triangles that have area; `None` where all have.
    kept: Option<Vec<u32>>,
}

/// Vertices of a mesh at a time, in the world.
struct Vertices {
    positions: Vec<Vec3>,
    /// Unit normals, zero where none can be computed; empty for flat shading.
    normals: Vec<Vec3>,
}

impl Vertices {
    /// Places vertices whose file gives these normals, or none.
    fn new(mesh: &Mesh, positions: &[Vec3], normals: &[Vec3], has_normals: bool, common: &Common) -> Self {
        let to_world = common.instance_to_world * common.to_world;
        let to_world = |position: &Vec3| to_world.transform_point3(position.as_dvec3()).as_vec3();
        let placed = positions.iter().map(to_world).collect();
        let normals = if has_normals { vertex_normals(mesh, positions, normals, common) } else { Vec::new() };
        Self { positions: placed, normals }
    }

    fn edges(&self, [a, b, c]: [u32; 3]) -> [Vec3; 2] {
        let [a, b, c] = [a, b, c].map(|vertex| self.positions[vertex as usize]);
        [b - a, c - a]
    }

    fn has_area(&self, corners: [u32; 3]) -> bool {
        let [edge_u, edge_v] = self.edges(corners);
        has_area(edge_u, edge_v)
    }

    fn is_finite(&self, corners: [u32; 3]) -> bool {
        let [edge_u, edge_v] = self.edges(corners);
        self.positions[corners[0] as usize].is_finite() && edge_u.cross(edge_v).length_squared().is_finite()
    }
}

impl<'a> PlacedMesh<'a> {
    /// Places the mesh; `None` where a coordinate is out of the range of single precision. It changes its shape where `deforms` is true and
    /// the mesh has the vertices of several times.
    pub fn new(mesh: &'a Mesh, options: &MeshOptions, common: &Common, deforms: bool) -> Option<Self> {
        let place = |positions: &[Vec3], normals: &[Vec3]| {
            Vertices::new(mesh, positions, normals, !options.face_normals, common)
        };
        let first = place(&mesh.positions, &mesh.normals);
        let later = if deforms { mesh.later_sets() } else { Vec::new() };
        let later = later.iter().map(|set| place(set.positions, set.normals)).collect();
        let mut placed = Self { mesh, flip_uvs: options.flip_uvs, common: *common, first, later, kept: None };
        let indices = 0..mesh.triangles.len();
        let sets = || [&placed.first].into_iter().chain(&placed.later);
        if !indices.clone().all(|index| sets().all(|set| set.is_finite(mesh.triangles[index]))) {
            return None;
        }
        let has_area = |&index: &usize| sets().any(|set| set.has_area(mesh.triangles[index]));
        if !indices.clone().all(|index| has_area(&index)) {
            placed.kept = Some(indices.filter(has_area).map(|index| index as u32).collect());
        }
        Some(placed)
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.kept.as_ref().map_or(self.mesh.triangles.len(), Vec::len)
    }

    /// Number of parts of the shutter's time at whose ends the mesh has vertices of its own; 0 where it keeps its shape.
    pub fn intervals(&self) -> usize {
        self.later.len()
    }

    /// Index in the mesh of triangle number `index`.
    fn index(&self, index: usize) -> usize {
        self.kept.as_ref().map_or(index, |kept| kept[index] as usize)
    }

    /// Makes triangle number `index`.
    pub fn triangle(&self, index: usize) -> Primitive {
        let index = self.index(index);
        let corners = self.mesh.triangles[index];
        let vertices = corners.map(|vertex| vertex as usize);
        let [edge_u, edge_v] = self.first.edges(corners);
        let flip = self.common.flip_normals ^ is_mirrored(&self.common.instance_to_world);
        let origin = self.first.positions[vertices[0]];
        let mut triangle = primitive(PrimitiveShape::Triangle, &self.common, origin, edge_u, edge_v, flip);
        if !self.first.normals.is_empty() {
            // Where the triangle has no area at first, a later set decides about its front.
            let whole = [&self.first].into_iter().chain(&self.later).find(|set| set.has_area(corners));
            let deciding = whole.unwrap_or(&self.first);
            let of = |set: &Vertices| vertices.map(|vertex| set.normals[vertex]);
            if let Some(flip) = flip_by_normals(of(deciding), deciding.edges(corners)) {
                triangle.flip_normal = flip;
            }
            triangle.normals = Some(filled(of(&self.first), edge_u, edge_v, triangle.flip_normal));
        }
        if !self.mesh.uvs.is_empty() {
            triangle.uvs = vertices.map(|vertex| self.uv(vertex));
        }
        if let Some(blocks) = self.common.colors {
            triangle.uvs = blocks.uvs(index as u32);
        }
        triangle
    }

    /// Triangle number `index` at all times, where the mesh changes its shape.
    pub fn keys(&self, index: usize) -> impl Iterator<Item = DeformedTriangle> + '_ {
        let Primitive { flip_normal, .. } = self.triangle(index);
        let corners = self.mesh.triangles[self.index(index)];
        [&self.first].into_iter().chain(&self.later).map(move |set| {
            let [edge_u, edge_v] = set.edges(corners);
            let of_corners = || corners.map(|vertex| set.normals[vertex as usize]);
            let normals = (!set.normals.is_empty()).then(|| filled(of_corners(), edge_u, edge_v, flip_normal));
            DeformedTriangle { vertices: corners.map(|vertex| set.positions[vertex as usize]), normals }
        })
    }

    fn uv(&self, vertex: usize) -> Vec2 {
        let uv = self.mesh.uvs[vertex];
        if self.flip_uvs { Vec2::new(uv.x, 1.0 - uv.y) } else { uv }
    }
}

/// Whether shading normals turn the geometric normal of a triangle to their side; `None` where they are zero. They decide which side is
/// the front, because Mitsuba uses them to tell whether light is emitted or reflected.
fn flip_by_normals(normals: [Vec3; 3], [edge_u, edge_v]: [Vec3; 2]) -> Option<bool> {
    let sum: Vec3 = normals.iter().sum();
    (sum != Vec3::ZERO).then(|| geometric_normal(edge_u, edge_v).dot(sum) < 0.0)
}

/// Normals of a triangle's corners; the geometric one in place of those that are zero.
fn filled(normals: [Vec3; 3], edge_u: Vec3, edge_v: Vec3, flip_normal: bool) -> [Vec3; 3] {
    let geometric = geometric_normal(edge_u, edge_v);
    let facing = if flip_normal { -geometric } else { geometric };
    normals.map(|normal| if normal == Vec3::ZERO { facing } else { normal })
}

/// Unit normal; any one where a triangle that deforms has no area at a time.
fn geometric_normal(edge_u: Vec3, edge_v: Vec3) -> Vec3 {
    edge_u.cross(edge_v).try_normalize().unwrap_or(Vec3::Z)
}

/// World-space unit normals of vertices in these positions, whose file gives these normals or none; zero where none can be computed.
fn vertex_normals(mesh: &Mesh, positions: &[Vec3], normals: &[Vec3], common: &Common) -> Vec<Vec3> {
    let sign = if common.flip_normals { -1.0 } else { 1.0 };
    let (to_world, instance) = (normal_matrix(&common.to_world), normal_matrix(&common.instance_to_world));
    if normals.is_empty() {
        let place = |normal: DVec3| (sign * (instance * normal).normalize_or_zero()).as_vec3();
        return smooth_normals(mesh, positions, &common.to_world).into_iter().map(place).collect();
    }
    let to_world = instance * to_world;
    let place = |normal: &Vec3| (sign * (to_world * normal.as_dvec3()).normalize_or_zero()).as_vec3();
    normals.iter().map(place).collect()
}

/// Sums of the adjacent faces' normals, weighted by the face's angle at the vertex, as in Mitsuba.
fn smooth_normals(mesh: &Mesh, positions: &[Vec3], to_world: &DMat4) -> Vec<DVec3> {
    let position = |vertex: u32| to_world.transform_point3(positions[vertex as usize].as_dvec3());
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for vertices in &mesh.triangles {
        for (vertex, weighted) in vertices.iter().zip(weighted_normals(vertices.map(position))) {
            sums[*vertex as usize] += weighted;
        }
    }
    sums
}

/// Normal of a face, scaled by the angle at each corner.
fn weighted_normals(corners: [DVec3; 3]) -> [DVec3; 3] {
    let [a, b, c] = corners;
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return [DVec3::ZERO; 3] };
    [(a, b, c), (b, c, a), (c, a, b)].map(|(at, left, right)| normal * (left - at).angle_between(right - at))
}

/// Whether the cross product is long enough to be normalized in f32, as the device will do. A value that is not a
/// number passes, so that it is reported rather than dropped.
fn has_area(edge_u: Vec3, edge_v: Vec3) -> bool {
    let length_squared = edge_u.cross(edge_v).length_squared();
    length_squared >= f32::MIN_POSITIVE || length_squared.is_nan()
}
