//! Sizes and iterations of the quadtrees of Müller, Gross and Novák (2017). They lie in the nodes and sums of set 2;
//! `glsl/include/guide/samplers/quadtree_nodes.glsl` says how.

use crate::generated::kernels::NODES_PER_LEAF;
use crate::settings::Settings;

/// Most nodes, however many bins the grid has: the nodes' sums must fit a storage buffer.
const MOST_NODES: u64 = 1 << 20;

/// Most nodes of all quadtrees: as many as the grid has bins, at most [`MOST_NODES`].
pub(crate) fn node_limit(settings: &Settings) -> u64 {
    // The finest grids have more bins than that. A grid whose size the scene chooses has no quadtrees.
    let cells = u64::from(settings.grid()).saturating_pow(3);
    cells.saturating_mul(settings.directions.pow(2).into()).min(MOST_NODES)
}

/// Most leaves of the tree that divides space; each has a quadtree.
pub(super) fn leaf_limit(settings: &Settings) -> u64 {
    node_limit(settings) / u64::from(NODES_PER_LEAF)
}

/// Quarters of all nodes. Each has a sum.
pub(crate) fn quarters(settings: &Settings) -> u64 {
    4 * node_limit(settings)
}

/// Texels of four words that the trees and the drafts of new trees take.
pub(crate) fn texels(settings: &Settings) -> u64 {
    let (nodes, leaves) = (node_limit(settings), leaf_limit(settings));
    // `leaf_count_place` and `draft_leaf_count_place` in GLSL.
    let last_of_trees = nodes + leaves + (2 * leaves).div_ceil(4);
    let last_of_drafts = nodes + 2 * leaves;
    last_of_trees + 1 + last_of_drafts + 1
}

/// Number of the iteration that ended after so many samples, if one did. Iterations of learning have 1, 2, 4, ... samples per
/// pixel.
pub(crate) fn ended_iteration(samples_done: u32) -> Option<u32> {
    let next = u64::from(samples_done) + 1;
    if next.is_power_of_two() { next.ilog2().checked_sub(1) } else { None }
}

/// Samples per pixel before the iteration under way.
pub(crate) fn first_of_iteration(samples_done: u32) -> u32 {
    let next = u64::from(samples_done) + 1;
    ((1_u64 << next.ilog2()) - 1) as u32
}

/// Samples per pixel that the iteration under way still takes.
pub(crate) fn samples_left(samples_done: u32) -> u32 {
    let next = u64::from(samples_done) + 1;
    let end = (1_u64 << (next.ilog2() + 1)) - 1;
    (end - u64::from(samples_done)).min(u32::MAX.into()) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_double() {
        let ended = |done| ended_iteration(done).map(|iteration| (done, iteration));
        assert_eq!((0..40).filter_map(ended).collect::<Vec<_>>(), [(1, 0), (3, 1), (7, 2), (15, 3), (31, 4)]);
        for done in 0..40 {
            let end = done + samples_left(done);
            let first = first_of_iteration(done);
            assert!(first <= done && (first == 0 || ended_iteration(first).is_some()) && end == 2 * first + 1);
            assert!(
                end > done && ended_iteration(end).is_some() && (done + 1..end).all(|at| ended_iteration(at).is_none())
            );
        }
        assert!(samples_left(u32::MAX) > 0);
    }
}
