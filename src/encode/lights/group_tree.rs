//! Trees of weights from which cells draw groups of lights, before they have learned anything. The layout is that of
//! `glsl/include/light/light_selection.glsl`.

use crate::encode::cosine_trees::{Node, pack};

/// Share of the draws that are made evenly among all groups that have power: `EVEN_SHARE` of
/// `glsl/kernels/learn/update_lights.comp`.
const EVEN_SHARE: f32 = 0.0625;

/// Weights of groups in a cell that has learned nothing, from the power of each group over that of all lights.
pub fn first_weights(powers: &[f32]) -> Vec<f32> {
    let used = powers.iter().filter(|&&power| power > 0.0).count() as f32;
    let weight = |&power: &f32| if power > 0.0 { (1.0 - EVEN_SHARE) * power + EVEN_SHARE / used } else { 0.0 };
    powers.iter().map(weight).collect()
}

/// Parts of a node.
const PARTS: usize = 16;

/// Number of nodes of a cell's tree of so many groups.
pub(crate) fn group_nodes(groups: u32) -> u32 {
    let parts = PARTS as u32;
    if groups > parts { 1 + groups / parts } else { groups / parts }
}

/// Tree of weights, one for each group.
pub fn group_tree(weights: &[f32]) -> Vec<Node> {
    let node = |parts: &[f32]| pack(parts.first_chunk().expect("sixteen parts"));
    let nodes = weights.chunks_exact(PARTS).map(node);
    if weights.len() <= PARTS {
        return nodes.collect();
    }
    let sums: Vec<f32> = weights.chunks_exact(PARTS).map(|parts| parts.iter().sum()).collect();
    std::iter::once(node(&sums)).chain(nodes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_group_with_power_is_forgotten() {
        let mut powers = vec![0.0; 256];
        (powers[3], powers[200]) = (1.0 - 1.0e-7, 1.0e-7);
        let weights = first_weights(&powers);
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1.0e-6);
        assert!(weights[200] > 0.03 && weights[3] > 0.96 && weights[4] == 0.0, "{weights:?}");
    }

    #[test]
    fn trees_have_the_nodes_that_kernels_expect() {
        for (groups, nodes) in [(0, 0), (16, 1), (256, 17)] {
            assert_eq!(group_nodes(groups), nodes);
            assert_eq!(group_tree(&vec![1.0; groups as usize]).len(), nodes as usize);
        }
        let mut weights = [0.0; 256];
        weights[35] = 3.0;
        let tree = group_tree(&weights);
        let is_empty = |node: usize| tree[node] == [0; 4];
        assert!((0..17).all(|node| is_empty(node) != [0, 3].contains(&node)), "{tree:?}");
    }
}
