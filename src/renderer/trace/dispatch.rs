//! How paths are traced: by one kernel that follows each to its end, or as waves.

use std::sync::Arc;
use std::time::Duration;

use crate::Result;
use crate::generated::kernels::{Kernels, Variant};
use crate::generated::layout::PathTracePush;
use crate::gpu::{Context, DescriptorSet, Kernel};
use crate::renderer::film_store::pages::FilmPage;
use crate::renderer::sets::frame::Frame;
use crate::renderer::statistics::Counts;
use crate::renderer::trace::slices::Slicer;
use crate::renderer::trace::wavefront::{Wavefront, wave_groups};
use crate::settings::Settings;

/// What traces paths.
pub(crate) enum Tracing {
    /// One kernel.
    Megakernel(Kernel),
    /// Several, edge by edge.
    Wavefront(Wavefront),
}

impl Tracing {
    /// Builds the kernels that the settings ask for, and what cuts their work into dispatches.
    pub fn new(
        context: &Arc<Context>,
        kernels: &Kernels,
        variant: &Variant,
        settings: &Settings,
    ) -> Result<(Self, Slicer)> {
        let groups = wave_groups(context.device(), settings);
        let slicer = Slicer::new(context.device(), settings, variant.workgroup_size, groups.unwrap_or(u32::MAX));
        let tracing = match groups {
            None => Self::Megakernel(Kernel::new(context, &kernels.path_trace, &variant.entries())?),
            Some(_) => Self::Wavefront(Wavefront::new(context, kernels, variant, settings)?),
        };
        Ok((tracing, slicer))
    }

    /// Traces a slice's samples and adds them to the film. Returns how long that took.
    pub fn trace(
        &self,
        context: &Arc<Context>,
        frame: &Frame,
        page: &FilmPage,
        others: [&DescriptorSet; 3],
        slice: PathTracePush,
    ) -> Result<(Duration, Counts)> {
        let [geometry, radiance_grid, normalization_grid] = others;
        let sets = [page.set(), geometry, radiance_grid, normalization_grid];
        let path_trace = match self {
            Self::Megakernel(kernel) => kernel,
            Self::Wavefront(wavefront) => return wavefront.trace(context, frame, sets, slice),
        };
        let label =
            format!("path_trace, samples {} to {}", slice.first_sample, slice.first_sample + slice.sample_count);
        let submission = context.submit(&label, |recorder| {
            frame.clear_counts(recorder);
            recorder.dispatch(path_trace, &sets, bytemuck::bytes_of(&slice), [slice.workgroup_count, 1, 1]);
            frame.hand_over_counts(recorder);
        })?;
        Ok((submission.wall, frame.read_counts()?))
    }
}
