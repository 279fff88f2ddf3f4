//! Memory of the paths of a wave.

use std::sync::Arc;

use crate::Result;
use crate::generated::kernels::{QUEUE_COUNT, SLOT_QUADRUPLES, TILE_PIXELS};
use crate::gpu::{Buffer, BufferKind, Context, DeviceInfo};
use crate::renderer::film_store::pages::padded_pixels;
use crate::settings::{Execution, Settings};

/// Bytes of a slot, with its word in each queue, the word of the instance that its ray has hit, and the weight of its flight.
const SLOT_BYTES: u64 = (SLOT_QUADRUPLES as u64 * 4 + QUEUE_COUNT as u64 + 1 + 3) * size_of::<u32>() as u64;
/// Most bytes of a wave: those of four million paths. More paths keep a device busy to the end of a wave; on an NVIDIA H100 half as
/// many cost 4 %, twice as many gained nothing.
const WAVE_BYTES: u64 = SLOT_BYTES << 22;
/// Part of the device's memory that a wave may take, as a divisor.
const PART_OF_MEMORY: u64 = 8;

/// Workgroups of pixels whose samples make up the largest wave; none where one kernel traces paths.
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

/// Buffer of a wave's paths; none where one kernel traces paths.
pub(crate) fn wave_buffer(context: &Arc<Context>, settings: &Settings) -> Result<Option<Arc<Buffer>>> {
    let bytes = wave_bytes(context.device(), settings);
    let buffer = || Buffer::new(context, "paths of a wave", bytes, BufferKind::Storage);
    (bytes > 0).then(buffer).transpose()
}
