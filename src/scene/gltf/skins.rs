//! Morph targets and skins.

use glam::{DMat3, DMat4, DVec3, DVec4};
use gltf::{Mesh, Node, Primitive, Skin};

use super::asset::Asset;
use super::nodes::Transforms;
use crate::Result;

/// Positions and normals of a primitive.
pub(super) struct Vertices {
    pub positions: Vec<DVec3>,
    /// One normal per vertex; empty where the file gives none.
    pub normals: Vec<DVec3>,
}

/// Moves vertices by the morph targets, with the weights of the node or else of the mesh.
pub(super) fn morph(
    asset: &Asset,
    node: &Node,
    mesh: &Mesh,
    primitive: &Primitive,
    vertices: &mut Vertices,
) -> Result<()> {
    let of_file =
        || node.weights().or_else(|| mesh.weights()).unwrap_or_default().iter().copied().map(f64::from).collect();
    let weights: Vec<f64> = asset.pose.weights(node.index()).map_or_else(of_file, <[f64]>::to_vec);
    for (target, weight) in primitive.morph_targets().zip(weights).filter(|(_, weight)| *weight != 0.0) {
        let moved = [(target.positions(), &mut vertices.positions), (target.normals(), &mut vertices.normals)];
        for (accessor, values) in moved {
            let Some(accessor) = accessor else { continue };
            for (value, by) in values.iter_mut().zip(asset.elements::<3>(&accessor)?) {
                *value += weight * DVec3::from_array(by);
            }
        }
    }
    Ok(())
}

/// Moves vertices to the world by the joints of a skin. Returns false where the primitive has no joints.
pub(super) fn skin(
    asset: &Asset,
    skin: &Skin,
    primitive: &Primitive,
    transforms: &Transforms,
    vertices: &mut Vertices,
) -> Result<bool> {
    let matrices = joint_matrices(asset, skin, transforms)?;
    let mut blended = vec![(DMat4::ZERO, 0.0); vertices.positions.len()];
    let mut set = 0;
    let attribute = |semantic| primitive.get(&semantic);
    while let (Some(joints), Some(weights)) =
        (attribute(gltf::Semantic::Joints(set)), attribute(gltf::Semantic::Weights(set)))
    {
        let (joints, weights) = (asset.elements::<4>(&joints)?, asset.elements::<4>(&weights)?);
        for ((blend, joints), weights) in blended.iter_mut().zip(joints).zip(weights) {
            for (joint, weight) in joints.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
                let matrix = matrices.get(joint as usize);
                let matrix = matrix.ok_or_else(|| asset.error(format!("skin {} lacks joint {joint}", skin.index())))?;
                *blend = (blend.0 + *matrix * weight, blend.1 + weight);
            }
        }
        set += 1;
    }
    if set == 0 {
        return Ok(false);
    }
    for (at, (matrix, weight)) in blended.into_iter().enumerate() {
        let matrix = if weight > 0.0 { matrix * (1.0 / weight) } else { DMat4::IDENTITY };
        vertices.positions[at] = (matrix * DVec4::from((vertices.positions[at], 1.0))).truncate();
        if let Some(normal) = vertices.normals.get_mut(at) {
            let linear = DMat3::from_mat4(matrix);
            *normal = linear.inverse().transpose() * *normal;
            if !normal.is_finite() {
                *normal = DVec3::ZERO;
            }
        }
    }
    Ok(true)
}

/// Transform of each joint from the space of the mesh to the world.
fn joint_matrices(asset: &Asset, skin: &Skin, transforms: &Transforms) -> Result<Vec<DMat4>> {
    let inverse = match skin.inverse_bind_matrices() {
        Some(accessor) => asset.elements::<16>(&accessor)?,
        None => Vec::new(),
    };
    let joint = |(index, joint): (usize, Node)| {
        let world = transforms.get(&joint.index()).copied().unwrap_or(DMat4::IDENTITY);
        world * inverse.get(index).map_or(DMat4::IDENTITY, DMat4::from_cols_array)
    };
    Ok(skin.joints().enumerate().map(joint).collect())
}
