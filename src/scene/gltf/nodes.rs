//! Nodes of the default scene with their transforms.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3};
use gltf::Node;

use super::asset::Asset;
use crate::Result;

/// Deepest nesting of nodes. Deeper nesting comes from a node that is its own descendant.
const MAX_DEPTH: usize = 512;
/// Most nodes with their instances.
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
    let mut list = Vec::new();
    match scene {
        Some(scene) => {
            for node in scene.nodes() {
                add(asset, node, DMat4::IDENTITY, 0, &mut list)?;
            }
        }
        None => return Err(asset.error("it has no scene; save it with one")),
    }
    Ok(list)
}

fn add<'a>(
    asset: &'a Asset,
    node: Node<'a>,
    world_from_parent: DMat4,
    depth: usize,
    list: &mut Vec<Placed<'a>>,
) -> Result<()> {
    if depth > MAX_DEPTH || list.len() > MAX_NODES {
        return Err(asset.error("its nodes are nested too deep, or too many: is one its own descendant?"));
    }
    let visible = node.extension_value("KHR_node_visibility").and_then(|value| value.get("visible")?.as_bool());
    if visible == Some(false) {
        return Ok(());
    }
    let columns = node.transform().matrix().map(|column| column.map(f64::from));
    let world_from_node = world_from_parent * DMat4::from_cols_array_2d(&columns);
    if !world_from_node.is_finite() {
        return Err(asset.error(format!("the transform of node {} is not finite", node.index())));
    }
    let instances = match node.extension_value("EXT_mesh_gpu_instancing") {
        Some(instancing) => instances(asset, instancing)?.into_iter().map(|own| world_from_node * own).collect(),
        None => vec![world_from_node],
    };
    list.push(Placed { node: node.clone(), world_from_node, instances });
    node.children().try_for_each(|child| add(asset, child, world_from_node, depth + 1, list))
}

/// Transforms of the instances of a node.
fn instances(asset: &Asset, extension: &serde_json::Value) -> Result<Vec<DMat4>> {
    let accessor = |name: &str| {
        let index = extension.get("attributes")?.get(name)?.as_u64()?;
        asset.document.accessors().nth(index as usize)
    };
    let vectors = |name: &str| accessor(name).map(|accessor| asset.elements::<3>(&accessor)).transpose();
    let (translations, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let rotations = accessor("ROTATION").map(|accessor| asset.elements::<4>(&accessor)).transpose()?;
    let counts = [&translations, &scales].map(|list| list.as_ref().map(Vec::len));
    let counts = counts.into_iter().chain([rotations.as_ref().map(Vec::len)]).flatten();
    let count = counts.reduce(usize::min).unwrap_or(0);
    if count > MAX_NODES {
        return Err(asset.error(format!("a node has {count} instances; no more than {MAX_NODES} are read")));
    }
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
