//! The quadtrees of Müller, Gross and Novák (2017): how much room they have, and when they are refined. What is in them says
//! `glsl/include/guide/samplers/quadtree_nodes.glsl`; they lie in the nodes and sums of set 2.

use crate::generated::kernels::{NODES_PER_LEAF, REFINE_DRAFT, REFINE_MEASURE, REFINE_PLACE, REFINE_SETTLE, Variant};
use crate::generated::layout::RefinePush;
use crate::gpu::{DescriptorSet, Kernel, Recorder};
use crate::settings::Settings;

/// No more nodes than this, however many bins the grid has: their sums are to fit a storage buffer.
const MOST_NODES: u64 = 1 << 20;
/// Workgroups that share the leaves when their trees are copied.
const SETTLE_GROUPS: u32 = 256;

/// Most nodes of all quadtrees: no more than the grid has bins.
pub(crate) fn node_limit(settings: &Settings) -> u64 {
    // The finest grids have more bins than that, and a grid whose size is chosen by the scene has no quadtrees.
    let cells = u64::from(settings.grid).saturating_pow(3);
    cells.saturating_mul(settings.directions.pow(2).into()).min(MOST_NODES)
}

fn leaf_limit(settings: &Settings) -> u64 {
    node_limit(settings) / u64::from(NODES_PER_LEAF)
}

/// Quarters of nodes, which have a sum each.
pub(crate) fn quarters(settings: &Settings) -> u64 {
    4 * node_limit(settings)
}

/// Texels of four words: the trees, and the drafts of new ones.
pub(crate) fn texels(settings: &Settings) -> u64 {
    let (nodes, leaves) = (node_limit(settings), leaf_limit(settings));
    // `leaf_count_place` and `draft_leaf_count_place` in GLSL.
    let last_of_trees = nodes + leaves + (2 * leaves).div_ceil(4);
    let last_of_drafts = nodes + 2 * leaves;
    last_of_trees + 1 + last_of_drafts + 1
}

/// Iterations of learning have 1, 2, 4, ... samples per pixel. The one that ended after so many samples, if one did.
pub(crate) fn ended_iteration(samples_done: u32) -> Option<u32> {
    let next = u64::from(samples_done) + 1;
    if next.is_power_of_two() { next.ilog2().checked_sub(1) } else { None }
}

/// Samples per pixel before the iteration under way.
pub(crate) fn first_of_iteration(samples_done: u32) -> u32 {
    let next = u64::from(samples_done) + 1;
    ((1_u64 << next.ilog2()) - 1) as u32
}

/// Samples per pixel that are left of the iteration under way.
pub(crate) fn samples_left(samples_done: u32) -> u32 {
    let next = u64::from(samples_done) + 1;
    let end = (1_u64 << (next.ilog2() + 1)) - 1;
    (end - u64::from(samples_done)).min(u32::MAX.into()) as u32
}

/// Ends an iteration: what it has learned is sampled from now on, and all sums start anew.
pub(crate) fn refine<'a>(
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
