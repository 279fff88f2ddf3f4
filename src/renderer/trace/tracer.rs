//! The tracer of a slice's paths: one kernel that follows each to its end, or waves.

use std::sync::Arc;
use std::time::Duration;

use crate::Result;
use crate::generated::kernels::{Kernels, Variant};
use crate::generated::layout::TracePush;
use crate::gpu::{Context, Kernel};
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::sets::Sets;
use crate::renderer::statistics::Counts;
use crate::renderer::trace::slices::Slicer;
use crate::renderer::trace::wave_memory::wave_groups;
use crate::renderer::trace::wavefront::Wavefront;
use crate::settings::Settings;

/// The kernels that trace paths.
pub(crate) enum Tracer {
    /// One kernel follows each path to its end.
    Megakernel(Kernel),
    /// Several kernels take all paths from edge to edge.
    Wavefront(Wavefront),
}

impl Tracer {
    /// Builds the kernels that the settings ask for, and the slicer that cuts their work into dispatches.
    pub fn new(
        context: &Arc<Context>,
        kernels: &Kernels,
        variant: &Variant,
        settings: &Settings,
    ) -> Result<(Self, Slicer)> {
        let groups = wave_groups(context.device(), settings);
        let slicer = Slicer::new(context.device(), settings, variant.workgroup_size, groups.unwrap_or(u32::MAX));
        let tracer = match groups {
            None => Self::Megakernel(Kernel::new(context, &kernels.trace, &variant.entries())?),
            Some(_) => Self::Wavefront(Wavefront::new(context, kernels, variant, settings)?),
        };
        Ok((tracer, slicer))
    }

    /// Traces a slice's samples and adds them to the film. Returns how long that took.
    pub fn trace(
        &self,
        context: &Arc<Context>,
        sets: &Sets,
        page: &FilmPage,
        slice: TracePush,
    ) -> Result<(Duration, Counts)> {
        let (frame, sets) = (&sets.frame, sets.of_page(page)?);
        let kernel = match self {
            Self::Megakernel(kernel) => kernel,
            Self::Wavefront(wavefront) => return wavefront.trace(context, frame, sets, slice),
        };
        let label = format!("trace, samples {} to {}", slice.first_sample, slice.first_sample + slice.sample_count);
        let submission = context.submit(&label, |recorder| {
            frame.clear_counts(recorder);
            recorder.dispatch(kernel, &sets, bytemuck::bytes_of(&slice), [slice.workgroup_count, 1, 1]);
            frame.hand_over_counts(recorder);
        })?;
        Ok((submission.wall, frame.read_counts()?))
    }
}
