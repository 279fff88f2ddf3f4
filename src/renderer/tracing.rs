//! How paths are traced: by one kernel that follows each to its end, as waves, or as the faster of the two.

use std::sync::Arc;
use std::time::Duration;

use super::execution::{Choice, Way};
use super::film_pages::FilmPage;
use super::frame::Frame;
use super::slices::Slicer;
use super::statistics::Counts;
use super::wavefront::{Wavefront, wave_groups};
use crate::Result;
use crate::gpu::{Context, DescriptorSet, Kernel};
use crate::kernels::{Kernels, Variant};
use crate::layout::PathTracePush;
use crate::settings::{Execution, Settings};

/// The kernels that trace paths, and how much each is given at once.
pub(super) struct Tracing {
    path_trace: Kernel,
    slicer: Slicer,
    waves: Option<Waves>,
}

struct Waves {
    wavefront: Wavefront,
    slicer: Slicer,
    /// Nothing where waves were asked for.
    choice: Option<Choice>,
}

impl Tracing {
    /// Builds what the settings and the device ask for.
    pub fn new(context: &Arc<Context>, kernels: &Kernels, variant: &Variant, settings: &Settings) -> Result<Self> {
        let slicer = |most| Slicer::new(context.device(), settings, variant.workgroup_size, most);
        let waves = |groups| {
            let choice = (settings.execution == Execution::Auto).then(Choice::default);
            Ok(Waves { wavefront: Wavefront::new(context, kernels, variant)?, slicer: slicer(groups), choice })
        };
        Ok(Self {
            path_trace: Kernel::new(context, &kernels.path_trace, &variant.entries())?,
            slicer: slicer(u32::MAX),
            waves: wave_groups(context.device(), settings).map(waves).transpose()?,
        })
    }

    /// The ways that paths may be traced.
    pub fn ways(&self) -> &'static [Way] {
        match &self.waves {
            None => &[Way::Megakernel],
            Some(Waves { choice: None, .. }) => &[Way::Wavefront],
            Some(_) => &[Way::Megakernel, Way::Wavefront],
        }
    }

    /// How the next batch of samples is to be traced.
    pub fn way(&mut self, batch: u32) -> Way {
        let Some(waves) = &mut self.waves else { return Way::Megakernel };
        waves.choice.as_mut().map_or(Way::Wavefront, |choice| choice.way(batch))
    }

    /// Takes note of how long a batch took.
    pub fn measured(&mut self, way: Way, batch: u32, elapsed: Duration) {
        if let Some(choice) = self.waves.as_mut().and_then(|waves| waves.choice.as_mut()) {
            choice.measured(way, batch, elapsed.as_secs_f64());
        }
    }

    /// What cuts batches into dispatches, and all other work.
    pub fn slicer(&self, way: Way) -> &Slicer {
        match (&self.waves, way) {
            (Some(waves), Way::Wavefront) => &waves.slicer,
            _ => &self.slicer,
        }
    }

    /// Traces a slice's samples and adds them to the film. Returns how long that took.
    pub fn trace(
        &self,
        way: Way,
        context: &Arc<Context>,
        frame: &Frame,
        page: &FilmPage,
        others: [&DescriptorSet; 3],
        slice: PathTracePush,
    ) -> Result<(Duration, Counts)> {
        if let (Some(waves), Way::Wavefront) = (&self.waves, way) {
            return waves.wavefront.trace(context, frame, page, others, slice);
        }
        let [geometry, radiance_grid, normalization_grid] = others;
        let sets = [page.set(), geometry, radiance_grid, normalization_grid];
        let label =
            format!("path_trace, samples {} to {}", slice.first_sample, slice.first_sample + slice.sample_count);
        let submission = context.submit(&label, |recorder| {
            frame.clear_counts(recorder);
            recorder.dispatch(&self.path_trace, &sets, bytemuck::bytes_of(&slice), [slice.workgroup_count, 1, 1]);
            frame.hand_over_counts(recorder);
        })?;
        Ok((submission.wall, frame.read_counts()?))
    }
}
