//! Paths as waves (Laine, Karras and Aila 2013, "Megakernels Considered Harmful"): all of a slice's paths travel an edge, then all
//! that go on travel the next. The pictures are those of the one kernel that follows each path to its end, bit for bit.

use std::sync::Arc;
use std::time::Duration;

use crate::generated::kernels::{Kernels, QUEUE_COUNT, SLOT_QUADRUPLES, TILE_PIXELS, Variant};
use crate::generated::layout::{PathTracePush, WavePush};
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet, DeviceInfo, DeviceKind, Kernel};
use crate::renderer::film_store::pages::padded_pixels;
use crate::renderer::sets::frame::Frame;
use crate::renderer::statistics::Counts;
use crate::settings::{Execution, Settings};
use crate::{Error, Result};

/// Bytes of a slot, with its word in each queue.
const SLOT_BYTES: u64 = (SLOT_QUADRUPLES as u64 * 4 + QUEUE_COUNT as u64) * size_of::<u32>() as u64;
/// Most bytes of a wave, some four million paths, and the most of the device's memory, as a part of it. More paths keep a device busy
/// to the end of a wave; on an NVIDIA H100 half as many cost 4 %, twice as many brought nothing.
const WAVE_BYTES: u64 = 800 << 20;
const PART_OF_MEMORY: u64 = 8;
/// Workgroups of a dispatch over a queue, whatever its length: its entries are dealt out to their lanes.
const QUEUE_GROUPS: u32 = 32_768;
/// Primitives from which on `auto` takes waves: among 18 they were slower, among 28,000 faster.
const LEAST_PRIMITIVES: usize = 10_000;
/// Edges between two looks at how many paths are left.
const EDGES_PER_SUBMISSION: u32 = 8;

/// What `auto` comes to: waves on a GPU, for emitter sampling in a scene that is not tiny, which is where they were faster. It
/// depends on nothing that varies from run to run, for a driver may round the arithmetic of other kernels otherwise.
pub(crate) fn chosen(device: &DeviceInfo, settings: &Settings, samples_lights: bool, primitives: usize) -> Execution {
    let can_trace = || device.limits.has_subgroup_ballot && settings.check_wavefront().is_ok();
    let pays = device.kind != DeviceKind::Cpu && samples_lights && primitives >= LEAST_PRIMITIVES;
    match settings.execution {
        Execution::Auto if pays && can_trace() => Execution::Wavefront,
        Execution::Auto => Execution::Megakernel,
        asked => asked,
    }
}

/// Refuses waves on a device that cannot count who goes on.
pub(crate) fn check_wavefront(device: &DeviceInfo, settings: &Settings) -> Result<()> {
    if settings.execution == Execution::Wavefront && !device.limits.has_subgroup_ballot {
        return Err(Error::Settings(format!(
            "--execution wavefront needs subgroup ballots, which {} lacks: take --execution megakernel",
            device.name
        )));
    }
    Ok(())
}

/// Workgroups of pixels whose samples make up the largest wave; none where paths are not traced as waves.
pub(crate) fn wave_groups(device: &DeviceInfo, settings: &Settings) -> Option<u32> {
    let limits = &device.limits;
    let bounds =
        [limits.max_storage_buffer_bytes, limits.max_allocation_bytes, limits.device_local_bytes / PART_OF_MEMORY];
    let most_bytes = bounds.into_iter().fold(WAVE_BYTES, u64::min);
    let most = (most_bytes / group_bytes(settings)).max(1);
    let groups = most.min(padded_pixels(settings) / u64::from(TILE_PIXELS)) as u32;
    (settings.execution == Execution::Wavefront).then_some(groups)
}

/// Bytes of the paths of a workgroup of pixels.
fn group_bytes(settings: &Settings) -> u64 {
    u64::from(TILE_PIXELS * settings.samples_per_dispatch) * SLOT_BYTES
}

/// Bytes of a wave's paths.
pub(crate) fn wave_bytes(device: &DeviceInfo, settings: &Settings) -> u64 {
    wave_groups(device, settings).map_or(0, |groups| u64::from(groups) * group_bytes(settings))
}

/// Where a wave's paths are kept.
pub(crate) fn wave_buffer(context: &Arc<Context>, settings: &Settings) -> Result<Option<Arc<Buffer>>> {
    let bytes = wave_bytes(context.device(), settings);
    let buffer = || Buffer::new(context, "paths of a wave", bytes, BufferKind::Storage);
    (bytes > 0).then(buffer).transpose()
}

/// The kernels of a wave.
pub(crate) struct Wavefront {
    /// Of each edge, in this order.
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
        slice: PathTracePush,
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
