//! The quadtrees of Müller, Gross and Novák (2017): how much room they have, and when they are refined. What is in them says
//! `glsl/include/quadtree_nodes.glsl`; they lie in the nodes and sums of set 2.

use crate::gpu::{DescriptorSet, Kernel, Recorder};
use crate::kernels::{REFINE_DRAFT, REFINE_MEASURE, REFINE_PLACE, REFINE_SETTLE, Variant};
use crate::layout::RefinePush;
use crate::settings::Settings;

/// `MOST_QUADTREE_NODES` in GLSL.
const MOST_NODES: u64 = 1 << 20;
/// `NODES_PER_LEAF` in GLSL.
const NODES_PER_LEAF: u64 = 8;
/// Workgroups that share the leaves when their trees are copied.
const SETTLE_GROUPS: u32 = 256;

/// Most nodes of all quadtrees: no more than the grid has bins.
pub(super) fn node_limit(settings: &Settings) -> u64 {
    (u64::from(settings.grid.pow(3)) * u64::from(settings.directions.pow(2))).min(MOST_NODES)
}

fn leaf_limit(settings: &Settings) -> u64 {
    node_limit(settings) / NODES_PER_LEAF
}

/// Quarters of nodes, which have a sum each.
pub(super) fn quarters(settings: &Settings) -> u64 {
    4 * node_limit(settings)
}

/// Texels of four words: the trees, and the drafts of new ones.
pub(super) fn texels(settings: &Settings) -> u64 {
    let (nodes, leaves) = (node_limit(settings), leaf_limit(settings));
    // `leaf_count_place` and `draft_leaf_count_place` in GLSL.
    let last_of_trees = nodes + leaves + (2 * leaves + 3) / 4;
    let last_of_drafts = nodes + 2 * leaves;
    last_of_trees + 1 + last_of_drafts + 1
}

/// The iteration of learning, if any, that ended with one of the steps after the first `before` of `after`: iteration k has
/// 2^k steps.
pub(super) fn ended_iteration(before: u32, after: u32) -> Option<u32> {
    (before + 1..=after).rev().find(|step| (step + 1).is_power_of_two()).map(|step| (step + 1).ilog2() - 1)
}

/// Ends an iteration: what it has learned is sampled from now on, and all sums start anew.
pub(super) fn refine<'a>(
    recorder: &mut Recorder<'a>,
    kernel: &'a Kernel,
    sets: &[&'a DescriptorSet],
    settings: &Settings,
    iteration: u32,
) {
    let leaf_groups = (leaf_limit(settings) as u32).div_ceil(Variant::default().workgroup_size);
    let stages =
        [(REFINE_MEASURE, leaf_groups), (REFINE_PLACE, 1), (REFINE_DRAFT, leaf_groups), (REFINE_SETTLE, SETTLE_GROUPS)];
    for (stage, groups) in stages {
        let push = RefinePush { stage, iteration };
        recorder.dispatch(kernel, sets, bytemuck::bytes_of(&push), [groups, 1, 1]);
        recorder.barrier();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_double() {
        let ends = |step| ended_iteration(step - 1, step);
        let ended: Vec<_> = (1..=40).filter_map(|step| ends(step).map(|iteration| (step, iteration))).collect();
        assert_eq!(ended, [(1, 0), (3, 1), (7, 2), (15, 3), (31, 4)]);
        assert_eq!((ended_iteration(0, 0), ended_iteration(3, 6), ended_iteration(2, 9)), (None, None, Some(2)));
    }
}
