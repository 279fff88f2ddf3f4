//! The refinement of quadtrees at the end of an iteration.

use std::sync::Arc;

use crate::Result;
use crate::generated::kernels::{Kernels, REFINE_DRAFT, REFINE_MEASURE, REFINE_PLACE, REFINE_SETTLE, Variant};
use crate::generated::layout::RefinePush;
use crate::gpu::{Context, Kernel};
use crate::renderer::learn::quadtrees::{ended_iteration, leaf_limit};
use crate::renderer::sets::Sets;
use crate::settings::Settings;

/// Workgroups that share the leaves when their trees are copied.
const SETTLE_GROUPS: u32 = 256;

/// The kernel that refines quadtrees.
pub(crate) struct Refinement(Kernel);

impl Refinement {
    pub fn new(context: &Arc<Context>, kernels: &Kernels, variant: &Variant) -> Result<Self> {
        Ok(Self(Kernel::new(context, &kernels.refine_quadtrees, &variant.entries())?))
    }

    /// Refines the quadtrees where an iteration ends after so many samples.
    pub fn end_batch(&self, context: &Arc<Context>, sets: &Sets, settings: &Settings, samples_done: u32) -> Result<()> {
        let iteration = ended_iteration(samples_done);
        iteration.map_or(Ok(()), |iteration| self.refine(context, sets, settings, iteration))
    }

    /// Ends an iteration: the quadtrees are sampled by what it has learned from now on, and all sums begin at zero.
    pub fn refine(&self, context: &Arc<Context>, sets: &Sets, settings: &Settings, iteration: u32) -> Result<()> {
        let sets = sets.without_film();
        let leaf_groups = (leaf_limit(settings) as u32).div_ceil(Variant::default().workgroup_size);
        let stages = [
            (REFINE_MEASURE, leaf_groups),
            (REFINE_PLACE, 1),
            (REFINE_DRAFT, leaf_groups),
            (REFINE_SETTLE, SETTLE_GROUPS),
        ];
        context.submit("refine_quadtrees", |recorder| {
            for (stage, groups) in stages {
                let push = RefinePush { stage, iteration };
                recorder.dispatch(&self.0, &sets, bytemuck::bytes_of(&push), [groups, 1, 1]);
                recorder.barrier();
            }
        })?;
        Ok(())
    }
}
