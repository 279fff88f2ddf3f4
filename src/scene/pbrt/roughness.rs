//! Roughness of pbrt's materials.

use super::maker::Maker;
use super::nodes::Node;
use crate::Result;

/// Roughness below which pbrt takes a surface for smooth.
const SMOOTH: f64 = 1.0e-3;

/// Facets of a surface by Mitsuba's `alpha`.
pub(super) enum Facets {
    Smooth,
    Even(Node),
    /// Roughness along `u` and along `v`.
    Uneven([Node; 2]),
}

/// Reads the roughness parameters whose names begin with `prefix`.
pub(super) fn read(maker: &mut Maker, prefix: &str) -> Result<Facets> {
    let entity = maker.entity;
    let parameters = &entity.parameters;
    let is_remapped = parameters.boolean("remaproughness", true)?;
    let mut alpha = |name: &str| -> Result<Node> {
        let node = maker.textures.number(parameters, name, 0.0)?;
        match is_remapped {
            true => maker.textures.square_root(node, entity),
            false => Ok(node),
        }
    };
    let [both, u, v] = ["roughness", "uroughness", "vroughness"].map(|name| format!("{prefix}{name}"));
    let facets = match (parameters.has(&u), parameters.has(&v)) {
        (false, false) => Facets::Even(alpha(&both)?),
        (has_u, has_v) => {
            parameters.ignore(&[&both]);
            Facets::Uneven([alpha(if has_u { &u } else { &both })?, alpha(if has_v { &v } else { &both })?])
        }
    };
    let is_smooth = |node: &Node| matches!(node, Node::Constant([alpha, ..]) if *alpha < SMOOTH);
    Ok(match facets {
        Facets::Even(node) if is_smooth(&node) => Facets::Smooth,
        Facets::Uneven([u, v]) if is_smooth(&u) && is_smooth(&v) => Facets::Smooth,
        Facets::Uneven([Node::Constant(u), Node::Constant(v)]) if u == v => Facets::Even(Node::Constant(u)),
        facets => facets,
    })
}

/// Roughness that is the same everywhere and in all directions; 0 where the surface is smooth. Says what is lost.
pub(super) fn uniform(maker: &mut Maker, facets: Facets) -> Result<f64> {
    let entity = maker.entity;
    let nodes = match facets {
        Facets::Smooth => return Ok(0.0),
        Facets::Even(node) => [node.clone(), node],
        Facets::Uneven(nodes) => {
            maker.warn("the coat is equally rough in all directions: the geometric mean is used");
            nodes
        }
    };
    let mut product = 1.0;
    for node in &nodes {
        product *= maker.textures.mean(node, entity)?;
    }
    if nodes.iter().any(|node| !matches!(node, Node::Constant(_))) {
        maker.warn("the coat is equally rough everywhere: the texture's mean is used");
    }
    Ok(product.sqrt())
}
