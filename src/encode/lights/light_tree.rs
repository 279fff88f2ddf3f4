//! Trees of weights from which cells draw groups of lights, before they have learned anything. The layout is that of
//! `glsl/include/light/light_selection.glsl`.

use crate::encode::cosine_trees::{Node, pack};

/// Parts of a node.
const PARTS: usize = 16;

/// Number of nodes of a cell's tree of so many groups.
pub(crate) fn light_nodes(groups: u32) -> u32 {
    let parts = PARTS as u32;
    if groups > parts { 1 + groups / parts } else { groups / parts }
}

/// Tree of weights, one for each group.
pub fn light_tree(weights: &[f32]) -> Vec<Node> {
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
    fn trees_have_the_nodes_that_kernels_expect() {
        for (groups, nodes) in [(0, 0), (16, 1), (256, 17)] {
            assert_eq!(light_nodes(groups), nodes);
            assert_eq!(light_tree(&vec![1.0; groups as usize]).len(), nodes as usize);
        }
        let mut weights = [0.0; 256];
        weights[35] = 3.0;
        let tree = light_tree(&weights);
        let is_empty = |node: usize| tree[node] == [0; 4];
        assert!((0..17).all(|node| is_empty(node) != [0, 3].contains(&node)), "{tree:?}");
    }
}
