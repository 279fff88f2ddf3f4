//! Shapes to world-space primitives.

use std::collections::HashMap;

use glam::{DMat4, DVec3, Vec2, Vec3};

use super::mesh::{Corner, Mesh};
use super::transform::{axes, is_mirrored, normal_matrix};
use super::{Primitive, PrimitiveShape};

/// What the primitives of one shape have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Common {
    pub to_world: DMat4,
    pub flip_normals: bool,
    pub material: u32,
    pub emitter: Option<u32>,
}

/// What `<shape type="obj">` can ask for besides.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeshOptions {
    pub face_normals: bool,
    pub flip_uvs: bool,
}

/// Texture coordinates of a triangle without any: its barycentric ones.
const BARYCENTRIC_UVS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// A square or disk in the xy plane, from -1 to 1, that faces `+z`.
pub(super) fn flat(shape: PrimitiveShape, common: &Common) -> Vec<Primitive> {
    oriented(shape, common, DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z).into_iter().collect()
}

/// The six faces of the cube from -1 to 1. Each is given by its center and where u and v run, so that the texture lies
/// on it as Mitsuba's does.
pub(super) fn cube(common: &Common) -> Vec<Primitive> {
    let [x, y, z] = DVec3::AXES;
    [(-y, z, x), (y, -x, -z), (x, y, -z), (z, y, x), (-x, y, z), (-z, -y, x)]
        .into_iter()
        .filter_map(|(outward, u, v)| oriented(PrimitiveShape::Parallelogram, common, outward, u, v, outward))
        .collect()
}

/// A flat shape given in object space, with the side that its normal points to; `None` if it has no area.
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
    // A normal goes along with its surface, so in a mirror the cross product turns over and the normal does not.
    let flip_normal = left_handed ^ is_mirrored(&common.to_world) ^ common.flip_normals;
    let origin = common.to_world.transform_point3(center).as_vec3();
    has_area(edge_u, edge_v).then(|| primitive(shape, common, origin, edge_u, edge_v, flip_normal))
}

/// The sphere that the unit sphere becomes; `to_world` is a similarity.
pub(super) fn sphere(common: &Common) -> Primitive {
    let [x, _, z] = axes(&common.to_world);
    let mirrored = is_mirrored(&common.to_world);
    let flip_normal = common.flip_normals ^ mirrored;
    let center = common.to_world.w_axis.truncate().as_vec3();
    let handedness = if mirrored { -1.0 } else { 1.0 };
    let sphere = primitive(PrimitiveShape::Sphere, common, center, x.as_vec3(), z.as_vec3(), flip_normal);
    Primitive { uvs: [Vec2::splat(handedness); 3], ..sphere }
}

fn primitive(
    shape: PrimitiveShape,
    common: &Common,
    origin: Vec3,
    edge_u: Vec3,
    edge_v: Vec3,
    flip_normal: bool,
) -> Primitive {
    let Common { material, emitter, .. } = *common;
    Primitive { shape, origin, edge_u, edge_v, normals: None, uvs: BARYCENTRIC_UVS, flip_normal, material, emitter }
}

/// The triangles of a mesh, without those that have no area.
pub(super) fn mesh(mesh: &Mesh, options: &MeshOptions, common: &Common) -> Vec<Primitive> {
    let to_world = |position: &Vec3| common.to_world.transform_point3(position.as_dvec3()).as_vec3();
    let positions: Vec<Vec3> = mesh.positions.iter().map(to_world).collect();
    let normals = if options.face_normals { Vec::new() } else { corner_normals(mesh, &positions, common) };
    let mut primitives = Vec::with_capacity(mesh.triangles.len());
    for (i, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|corner| positions[corner.position as usize]);
        let (edge_u, edge_v) = (b - a, c - a);
        if !has_area(edge_u, edge_v) {
            continue;
        }
        let mut triangle = primitive(PrimitiveShape::Triangle, common, a, edge_u, edge_v, common.flip_normals);
        if let Some(normals) = normals.get(i) {
            set_normals(&mut triangle, normals);
        }
        if !mesh.uvs.is_empty() {
            triangle.uvs = corners.map(|corner| uv(mesh, &corner, options));
        }
        primitives.push(triangle);
    }
    primitives
}

/// Shading normals say which side is the front: it is by them that Mitsuba tells whether light is emitted or reflected.
/// The geometric normal follows.
fn set_normals(triangle: &mut Primitive, normals: &[Vec3; 3]) {
    let geometric = triangle.edge_u.cross(triangle.edge_v).normalize();
    let sum: Vec3 = normals.iter().sum();
    if sum != Vec3::ZERO {
        triangle.flip_normal = geometric.dot(sum) < 0.0;
    }
    let facing = if triangle.flip_normal { -geometric } else { geometric };
    triangle.normals = Some(normals.map(|normal| if normal == Vec3::ZERO { facing } else { normal }));
}

fn uv(mesh: &Mesh, corner: &Corner, options: &MeshOptions) -> Vec2 {
    let uv = mesh.uvs[corner.uv as usize];
    if options.flip_uvs { Vec2::new(uv.x, 1.0 - uv.y) } else { uv }
}

/// World-space unit normals of every triangle's corners; zero where there is none to be had.
fn corner_normals(mesh: &Mesh, positions: &[Vec3], common: &Common) -> Vec<[Vec3; 3]> {
    let sign = if common.flip_normals { -1.0 } else { 1.0 };
    if mesh.normals.is_empty() {
        return smooth_normals(mesh, positions, sign);
    }
    let to_world = normal_matrix(&common.to_world);
    let transform = |normal: &Vec3| (sign * (to_world * normal.as_dvec3()).normalize_or_zero()).as_vec3();
    let normals: Vec<Vec3> = mesh.normals.iter().map(transform).collect();
    mesh.triangles.iter().map(|corners| corners.map(|corner| normals[corner.normal as usize])).collect()
}

/// The mean of the adjacent faces' normals, weighted by the angle the face has at the vertex. Vertices that differ in
/// their texture coordinates are different vertices, as in Mitsuba.
fn smooth_normals(mesh: &Mesh, positions: &[Vec3], sign: f64) -> Vec<[Vec3; 3]> {
    let mut vertices = HashMap::new();
    let mut sums = Vec::new();
    let mut indices = Vec::with_capacity(mesh.triangles.len());
    for corners in &mesh.triangles {
        let ids = corners.map(|corner| {
            *vertices.entry((corner.position, corner.uv)).or_insert_with(|| {
                sums.push(DVec3::ZERO);
                sums.len() - 1
            })
        });
        let corners = corners.map(|corner| positions[corner.position as usize].as_dvec3());
        for (id, weighted) in ids.into_iter().zip(weighted_normals(corners)) {
            sums[id] += weighted;
        }
        indices.push(ids);
    }
    let normals: Vec<Vec3> = sums.into_iter().map(|sum| (sign * sum.normalize_or_zero()).as_vec3()).collect();
    indices.into_iter().map(|ids| ids.map(|id| normals[id])).collect()
}

/// The face's normal, scaled with the angle at each corner.
fn weighted_normals(corners: [DVec3; 3]) -> [DVec3; 3] {
    let [a, b, c] = corners;
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return [DVec3::ZERO; 3] };
    [(a, b, c), (b, c, a), (c, a, b)].map(|(at, left, right)| normal * (left - at).angle_between(right - at))
}

/// Whether the cross product is long enough to be normalized in f32, which is what the device will do. What is not a
/// number passes here, so that it is reported rather than dropped.
fn has_area(edge_u: Vec3, edge_v: Vec3) -> bool {
    let length_squared = edge_u.cross(edge_v).length_squared();
    length_squared >= f32::MIN_POSITIVE || length_squared.is_nan()
}
