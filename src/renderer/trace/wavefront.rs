//! Paths as waves (Laine, Karras and Aila 2013, "Megakernels Considered Harmful"): all of a slice's paths travel an edge, then
//! all that go on travel the next. The picture has the same bits as one kernel's that follows each path to its end.

use std::sync::Arc;
use std::time::Duration;

use crate::Result;
use crate::generated::kernels::{Kernels, Variant};
use crate::generated::layout::{TracePush, WavePush};
use crate::gpu::{Context, DescriptorSet, Kernel};
use crate::renderer::sets::frame::Frame;
use crate::renderer::statistics::Counts;
use crate::settings::Settings;

/// Workgroups of a dispatch over a queue. Their lanes share the queue's entries, however many there are.
const QUEUE_GROUPS: u32 = 32_768;
/// Edges that one submission traces before the host looks how many paths are left.
const EDGES_PER_SUBMISSION: u32 = 8;

/// The kernels of a wave.
pub(crate) struct Wavefront {
    /// Kernels of an edge, in this order.
    stages: Vec<Kernel>,
    film: Kernel,
    max_depth: u32,
    queue_groups: u32,
}

impl Wavefront {
    pub fn new(context: &Arc<Context>, kernels: &Kernels, variant: &Variant, settings: &Settings) -> Result<Self> {
        let build = |source| Kernel::new(context, source, &variant.entries());
        let stages = match variant.nee {
            true => vec![&kernels.wave_extend, &kernels.wave_connect, &kernels.wave_shadow, &kernels.wave_shade],
            false => vec![&kernels.wave_extend, &kernels.wave_shade],
        };
        Ok(Self {
            stages: stages.into_iter().map(build).collect::<Result<_>>()?,
            film: build(&kernels.wave_film)?,
            max_depth: variant.max_depth,
            queue_groups: settings.queue_groups.unwrap_or(QUEUE_GROUPS),
        })
    }

    /// Traces the slice's samples and adds them to the film. Returns how long that took.
    pub fn trace(
        &self,
        context: &Arc<Context>,
        frame: &Frame,
        sets: [&DescriptorSet; 4],
        slice: TracePush,
    ) -> Result<(Duration, Counts)> {
        let slots = slice.workgroup_count * slice.sample_count.max(1);
        let groups = [slots.min(self.queue_groups), 1, 1];
        let mut elapsed = Duration::ZERO;
        let mut edge = 0;
        loop {
            let end = self.max_depth.min(edge + EDGES_PER_SUBMISSION);
            let end_of_samples = slice.first_sample + slice.sample_count;
            let label = format!(
                "wave_extend to wave_shade, edges {edge} to {end}, samples {} to {end_of_samples}",
                slice.first_sample
            );
            let submission = context.submit(&label, |recorder| {
                if edge == 0 {
                    frame.clear_counts(recorder);
                }
                for edge in edge..end {
                    let push = WavePush { slice, edge };
                    for kernel in &self.stages {
                        recorder.dispatch(kernel, &sets, bytemuck::bytes_of(&push), groups);
                        recorder.barrier();
                    }
                }
                frame.hand_over_counts(recorder);
            })?;
            elapsed += submission.wall;
            edge = end;
            if edge == self.max_depth || frame.read_queued(edge)? == 0 {
                break;
            }
        }
        let push = WavePush { slice, edge };
        let submission = context.submit("wave_film", |recorder| {
            recorder.dispatch(&self.film, &sets, bytemuck::bytes_of(&push), [slice.workgroup_count, 1, 1]);
            frame.hand_over_counts(recorder);
        })?;
        Ok((elapsed + submission.wall, frame.read_counts()?))
    }
}
