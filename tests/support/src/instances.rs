//! Instances and the copies that show the same.

use glam::{DMat3, DMat4, DVec3, Vec3};
use lodestar::scene::{Instance, Primitive, Scene};

use crate::scenes::ours;

/// The scene with copies in place of its instances, which follow its own primitives in the order of the instances.
pub fn copied(scene: &Scene) -> Scene {
    let mut copies = scene.clone();
    let (groups, instances) = (std::mem::take(&mut copies.groups), std::mem::take(&mut copies.instances));
    for instance in &instances {
        copies.primitives.extend(groups[instance.group as usize].primitives.iter().map(|p| copy(p, instance)));
    }
    copies
}

/// Copy of a flat primitive in the place of an instance.
fn copy(p: &Primitive, instance: &Instance) -> Primitive {
    let matrix = instance.world_from_group();
    let inverse_transpose = matrix.inverse().transpose();
    let turned = |v: Vec3| (matrix * v.as_dvec3()).as_vec3();
    let normal = |n: Vec3| (inverse_transpose * n.as_dvec3()).normalize().as_vec3();
    Primitive {
        origin: (instance.origin.as_dvec3() + matrix * p.origin.as_dvec3()).as_vec3(),
        edge_u: turned(p.edge_u),
        edge_v: turned(p.edge_v),
        normals: p.normals.map(|normals| normals.map(normal)),
        flip_normal: p.flip_normal ^ (matrix.determinant() < 0.0),
        ..*p
    }
}

/// Scene of a dented ball with smooth normals, which reflects 0.7 of the light. There is no light.
pub fn dented_ball() -> Scene {
    let mut scene = ours("furnace/mesh.xml", &[("albedo", "0.7"), ("emission", "0")]);
    for primitive in &mut scene.primitives {
        let corners = [primitive.origin, primitive.origin + primitive.edge_u, primitive.origin + primitive.edge_v];
        primitive.emitter = None;
        primitive.normals = Some(corners.map(|corner| corner.normalize()));
        primitive.flip_normal = false;
    }
    scene.emitters.clear();
    scene
}

/// Transforms of all kinds, with what they do: of about the size 1 but for the named scale, and turned.
pub fn transforms() -> Vec<(&'static str, DMat4)> {
    let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-0.4);
    let scale = |x: f64, y: f64, z: f64| DMat3::from_diagonal(DVec3::new(x, y, z));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(1.5, 1.0, 0.0), DVec3::new(0.3, -0.8, 1.0));
    let cases = [
        ("the identity", DMat3::IDENTITY, DVec3::ZERO),
        ("a move", DMat3::IDENTITY, DVec3::new(0.3, -0.4, 0.2)),
        ("a turn", turn, DVec3::new(-0.2, 0.1, 0.3)),
        ("a mirror", scale(-1.0, 1.0, 1.0), DVec3::new(0.1, 0.0, 0.0)),
        ("a turned mirror", turn * scale(1.0, -0.8, 1.0), DVec3::ZERO),
        ("uneven scales", turn * scale(0.4, 1.6, 0.9), DVec3::new(0.0, 0.2, 0.0)),
        ("a shear", shear, DVec3::ZERO),
        ("a turned, mirrored shear", turn * scale(1.0, 1.0, -0.7) * shear, DVec3::new(0.0, 0.0, -0.3)),
    ];
    cases
        .into_iter()
        .map(|(name, matrix, origin)| (name, DMat4::from_translation(origin) * DMat4::from_mat3(matrix)))
        .collect()
}
