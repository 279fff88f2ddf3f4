//! Pose of a model's nodes, where it is another than the file's.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3};
use gltf::Node;

/// Pose of the nodes that an animation moves, by their indices.
#[derive(Default)]
pub(super) struct Pose(HashMap<usize, Moved>);

/// Parts of a node's transform, and weights of its morph targets, that an animation sets.
#[derive(Default)]
pub(super) struct Moved {
    pub translation: Option<DVec3>,
    pub rotation: Option<DQuat>,
    pub scale: Option<DVec3>,
    pub weights: Option<Vec<f64>>,
}

impl Pose {
    /// Parts of a node that are set.
    pub fn moved(&mut self, node: usize) -> &mut Moved {
        self.0.entry(node).or_default()
    }

    /// Transform of a node to its parent's space; `None` where the animation leaves it as the file says.
    pub fn transform(&self, node: &Node) -> Option<DMat4> {
        let Moved { translation, rotation, scale, .. } = self.0.get(&node.index())?;
        if translation.is_none() && rotation.is_none() && scale.is_none() {
            return None;
        }
        let (own_translation, own_rotation, own_scale) = node.transform().decomposed();
        let vector = |own: [f32; 3]| DVec3::from_array(own.map(f64::from));
        Some(DMat4::from_scale_rotation_translation(
            scale.unwrap_or_else(|| vector(own_scale)),
            rotation.unwrap_or_else(|| quaternion(&own_rotation.map(f64::from))),
            translation.unwrap_or_else(|| vector(own_translation)),
        ))
    }

    /// Weights of a node's morph targets; `None` where the animation leaves them.
    pub fn weights(&self, node: usize) -> Option<&[f64]> {
        self.0.get(&node)?.weights.as_deref()
    }
}

/// Quaternion of length 1; no rotation where it has none.
pub(super) fn quaternion(value: &[f64]) -> DQuat {
    let own = DQuat::from_xyzw(value[0], value[1], value[2], value[3]);
    if own.is_finite() && own.length() > 0.0 { own.normalize() } else { DQuat::IDENTITY }
}
