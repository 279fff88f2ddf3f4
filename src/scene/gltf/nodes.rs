//! Nodes of the default scene with their transforms.

use std::collections::{HashMap, HashSet};

use glam::{DMat4, DQuat, DVec3};
use gltf::{Accessor, Node};

use super::asset::Asset;
use crate::{Error, Result};

/// Deepest nesting of nodes. Deeper nesting comes from a node that is its own descendant.
const MAX_DEPTH: usize = 512;
/// Most nodes of a scene, each counted as often as it has instances.
const MAX_NODES: usize = 1 << 20;

/// Node with the transforms from its space to the world.
pub(super) struct Placed<'a> {
    pub node: Node<'a>,
    /// Transform of the node itself.
    pub world_from_node: DMat4,
    /// Transforms of its instances (`EXT_mesh_gpu_instancing`), or the node's own.
    pub instances: Vec<DMat4>,
}

/// Transform of each node of the scene by the node's index.
pub(super) type Transforms = HashMap<usize, DMat4>;

/// Visible nodes of the default scene; of the first scene, where none is the default; or of no scene at all.
pub(super) fn placed(asset: &Asset) -> Result<Vec<Placed<'_>>> {
    let document = &asset.document;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    if document.scenes().len() > 1 {
        asset.warn("it has several scenes; the default one is rendered");
    }
    let mut found = Found { asset, list: Vec::new(), count: 0 };
    match scene {
        Some(scene) => scene.nodes().try_for_each(|node| found.add(&node, DMat4::IDENTITY, 0))?,
        None => {
            // A file may be a library of nodes.
            asset.warn("it has no scene; all its nodes are rendered");
            let children: HashSet<usize> =
                document.nodes().flat_map(|node| node.children()).map(|node| node.index()).collect();
            let mut roots = document.nodes().filter(|node| !children.contains(&node.index()));
            roots.try_for_each(|node| found.add(&node, DMat4::IDENTITY, 0))?;
        }
    }
    Ok(found.list)
}

/// Nodes that have been found.
struct Found<'a> {
    asset: &'a Asset,
    list: Vec<Placed<'a>>,
    /// Number of nodes, each counted as often as it has instances; at most [`MAX_NODES`].
    count: usize,
}

impl<'a> Found<'a> {
    /// Adds a node and its descendants.
    fn add(&mut self, node: &Node<'a>, world_from_parent: DMat4, depth: usize) -> Result<()> {
        if depth > MAX_DEPTH {
            return Err(self.asset.error("its nodes are nested too deep: is one its own descendant?"));
        }
        let visible = node.extension_value("KHR_node_visibility").and_then(|value| value.get("visible")?.as_bool());
        if visible == Some(false) {
            return Ok(());
        }
        let of_file = || {
            let columns = node.transform().matrix().map(|column| column.map(f64::from));
            // Some writers round the last entry of a matrix, which is 1.
            let scale = Some(columns[3][3]).filter(|last| (last - 1.0).abs() < 1.0e-4).unwrap_or(1.0);
            DMat4::from_cols_array_2d(&columns) * scale.recip()
        };
        let world_from_node = world_from_parent * self.asset.pose.transform(node).unwrap_or_else(of_file);
        if !world_from_node.is_finite() {
            return Err(self.asset.error(format!("the transform of node {} is not finite", node.index())));
        }
        let left = MAX_NODES - self.count;
        let instances: Vec<DMat4> = match node.extension_value("EXT_mesh_gpu_instancing") {
            Some(instancing) => {
                instances(self.asset, instancing, left)?.into_iter().map(|own| world_from_node * own).collect()
            }
            None => vec![world_from_node],
        };
        let count = instances.len().max(1);
        if count > left {
            return Err(too_many(self.asset));
        }
        self.count += count;
        self.list.push(Placed { node: node.clone(), world_from_node, instances });
        node.children().try_for_each(|child| self.add(&child, world_from_node, depth + 1))
    }
}

fn too_many(asset: &Asset) -> Error {
    asset.error(format!("it has more than {MAX_NODES} nodes, which count once for each instance; save it in parts"))
}

/// Transforms of the instances of a node, of which there may be `most`.
fn instances(asset: &Asset, extension: &serde_json::Value, most: usize) -> Result<Vec<DMat4>> {
    let accessor = |name: &str| {
        let index = extension.get("attributes")?.get(name)?.as_u64()?;
        asset.document.accessors().nth(index as usize)
    };
    let (translations, rotations, scales) = (accessor("TRANSLATION"), accessor("ROTATION"), accessor("SCALE"));
    let counts = [&translations, &rotations, &scales].into_iter().flatten().map(Accessor::count);
    let count = counts.reduce(usize::min).unwrap_or(0);
    if count > most {
        return Err(too_many(asset));
    }
    let vectors = |list: Option<Accessor>| list.map(|list| asset.elements::<3>(&list)).transpose();
    let (translations, scales) = (vectors(translations)?, vectors(scales)?);
    let rotations = rotations.map(|list| asset.elements::<4>(&list)).transpose()?;
    let vector = |list: &Option<Vec<[f64; 3]>>, at: usize, default: DVec3| {
        list.as_ref().map_or(default, |list| DVec3::from_array(list[at]))
    };
    Ok((0..count)
        .map(|at| {
            let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |list| DQuat::from_array(list[at]).normalize());
            DMat4::from_scale_rotation_translation(
                vector(&scales, at, DVec3::ONE),
                rotation,
                vector(&translations, at, DVec3::ZERO),
            )
        })
        .collect())
}

/// Transforms of all nodes of the list.
pub(super) fn transforms(list: &[Placed]) -> Transforms {
    list.iter().map(|placed| (placed.node.index(), placed.world_from_node)).collect()
}
