//! The update of the grids at the end of a step.

use std::ops::Range;
use std::sync::Arc;

use crate::Result;
use crate::encode::cells::Cells;
use crate::generated::kernels::{Kernels, Variant};
use crate::generated::layout::UpdatePush;
use crate::gpu::{Context, Kernel};
use crate::renderer::sets::Sets;
use crate::renderer::trace::slices::Slicer;
use crate::settings::Settings;

/// Kernels that update the grids.
pub(crate) struct GridUpdates {
    radiance: Kernel,
    /// Kernels for cells that borrow from the larger cells that they are part of.
    parents: Option<Parents>,
    /// Kernel for cells that learn which lights to draw.
    lights: Option<Kernel>,
    normalization: Kernel,
}

/// Kernels that pass learned radiance up and down the hierarchy of cells.
struct Parents {
    pool: Kernel,
    blend: Kernel,
}

impl GridUpdates {
    pub fn new(context: &Arc<Context>, kernels: &Kernels, variant: &Variant, settings: &Settings) -> Result<Self> {
        let build = |source| Kernel::new(context, source, &variant.entries());
        let parents = || Ok(Parents { pool: build(&kernels.pool_radiance)?, blend: build(&kernels.blend_radiance)? });
        Ok(Self {
            radiance: build(&kernels.update_radiance)?,
            parents: (settings.fallback() > 0.0).then(parents).transpose()?,
            lights: (variant.light_groups > 0).then(|| build(&kernels.update_lights)).transpose()?,
            normalization: build(&kernels.update_normalization)?,
        })
    }

    /// Moves the radiance grid towards the step's targets (Eq. 7), blends cells with their parents, and computes the marked
    /// normalizers anew.
    pub fn run(&self, context: &Arc<Context>, slicer: &Slicer, sets: &Sets, cells: &Cells) -> Result<()> {
        let update = |cells, kernels: &[&Kernel]| update(context, slicer, sets, cells, kernels);
        let all = 0..cells.count();
        if let Some(lights) = &self.lights {
            update(all.clone(), &[lights])?;
        }
        let Some(Parents { pool, blend }) = &self.parents else {
            return update(all, &[&self.radiance, &self.normalization]);
        };
        update(all.clone(), &[&self.radiance])?;
        let levels = cells.parent_levels();
        levels.iter().try_for_each(|level| update(level.clone(), &[pool]))?;
        levels.iter().rev().try_for_each(|level| update(level.clone(), &[blend]))?;
        update(all, &[blend, &self.normalization])
    }
}

/// Runs kernels one after the other, each with a workgroup per cell.
fn update(context: &Arc<Context>, slicer: &Slicer, sets: &Sets, cells: Range<u32>, kernels: &[&Kernel]) -> Result<()> {
    let sets = sets.without_film();
    let names: Vec<_> = kernels.iter().map(|kernel| kernel.name()).collect();
    for range in slicer.ranges(cells) {
        let push = UpdatePush { first_cell: range.start };
        context.submit(&names.join(" and "), |recorder| {
            for kernel in kernels {
                recorder.dispatch(kernel, &sets, bytemuck::bytes_of(&push), [range.end - range.start, 1, 1]);
                recorder.barrier();
            }
        })?;
    }
    Ok(())
}
