//! The update of the grids at the end of a step.

use std::ops::Range;
use std::sync::Arc;

use crate::Result;
use crate::encode::cells::Cells;
use crate::generated::constants::LANES_PER_CELL;
use crate::generated::kernels::{Kernels, Variant};
use crate::generated::layout::{BlendPush, UpdatePush};
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
    /// normalizers anew. Earlier targets count less from now on if this ends a step.
    pub fn run(
        &self,
        context: &Arc<Context>,
        slicer: &Slicer,
        sets: &Sets,
        cells: &Cells,
        ends_step: bool,
    ) -> Result<()> {
        let update = |cells, kernel: &Kernel| update(context, slicer, sets, cells, kernel, ends_step);
        let all = 0..cells.count();
        if let Some(lights) = &self.lights {
            update(all.clone(), lights)?;
        }
        let Some(Parents { pool, blend }) = &self.parents else {
            update(all.clone(), &self.radiance)?;
            return update(all, &self.normalization);
        };
        update(all.clone(), &self.radiance)?;
        let levels = cells.parent_levels();
        levels.iter().try_for_each(|level| update(level.clone(), pool))?;
        let blend = |level: &Range<u32>| blend_cells(context, slicer, sets, level.clone(), blend);
        levels.iter().rev().try_for_each(blend)?;
        blend(&all)?;
        update(all, &self.normalization)
    }
}

/// Runs a kernel with a workgroup per cell.
fn update(
    context: &Arc<Context>,
    slicer: &Slicer,
    sets: &Sets,
    cells: Range<u32>,
    kernel: &Kernel,
    ends_step: bool,
) -> Result<()> {
    let submit = |range: Range<u32>| {
        let push = UpdatePush { first_cell: range.start, ends_step: ends_step.into() };
        submit(context, sets, kernel, bytemuck::bytes_of(&push), range.end - range.start)
    };
    slicer.ranges(cells).try_for_each(submit)
}

/// Runs `blend_radiance`, which has workgroups for several cells.
fn blend_cells(context: &Arc<Context>, slicer: &Slicer, sets: &Sets, cells: Range<u32>, kernel: &Kernel) -> Result<()> {
    let cells_per_group = Variant::default().workgroup_size / LANES_PER_CELL;
    let submit = |range: Range<u32>| {
        let push = BlendPush { first_cell: range.start, end_cell: range.end };
        let groups = (range.end - range.start).div_ceil(cells_per_group);
        submit(context, sets, kernel, bytemuck::bytes_of(&push), groups)
    };
    slicer.ranges(cells).try_for_each(submit)
}

fn submit(context: &Arc<Context>, sets: &Sets, kernel: &Kernel, push: &[u8], groups: u32) -> Result<()> {
    context.submit(kernel.name(), |recorder| {
        recorder.dispatch(kernel, &sets.without_film(), push, [groups, 1, 1]);
        recorder.barrier();
    })?;
    Ok(())
}
