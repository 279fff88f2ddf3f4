//! The device's own clock.

use std::sync::Arc;
use std::time::Duration;

use ash::vk;

use super::context::Context;
use super::fault::failed;
use crate::Result;

/// Two timestamps around a command buffer's work.
pub(super) struct Clock {
    raw: vk::QueryPool,
    context: Arc<Context>,
}

impl Clock {
    /// Nothing where the queue cannot tell the time.
    pub(super) fn new(context: &Arc<Context>) -> Result<Option<Self>> {
        if context.logical().timestamp_bits() == 0 {
            return Ok(None);
        }
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2);
        // SAFETY: invariant 1: the device is alive, and `info` is a local.
        let raw = unsafe { context.raw().create_query_pool(&info, None) }.map_err(failed("vkCreateQueryPool"))?;
        Ok(Some(Self { raw, context: Arc::clone(context) }))
    }

    /// Records the start.
    pub(super) fn start(&self, commands: vk::CommandBuffer) {
        let device = self.context.raw();
        // SAFETY: invariants 1 and 3: the recorder owns the clock and the command buffer, which is being recorded.
        unsafe {
            device.cmd_reset_query_pool(commands, self.raw, 0, 2);
            device.cmd_write_timestamp(commands, vk::PipelineStageFlags::TOP_OF_PIPE, self.raw, 0);
        }
    }

    /// Records the end.
    pub(super) fn stop(&self, commands: vk::CommandBuffer) {
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: invariants 1 and 3: the recorder owns the clock and the command buffer, which is being recorded.
        unsafe { self.context.raw().cmd_write_timestamp(commands, stage, self.raw, 1) }
    }

    /// The time between the two, once the submission is done.
    pub(super) fn elapsed(&self) -> Option<Duration> {
        let mut ticks = [0_u64; 2];
        // SAFETY: invariant 1: device and queries are alive, and the slice has room for both.
        let result = unsafe {
            self.context.raw().get_query_pool_results(self.raw, 0, &mut ticks, vk::QueryResultFlags::TYPE_64)
        };
        let period = f64::from(self.context.device().limits.timestamp_nanoseconds);
        let elapsed = ticks_between(ticks, self.context.logical().timestamp_bits());
        result.ok().map(|()| Duration::from_secs_f64(elapsed as f64 * period * 1e-9))
    }
}

impl Drop for Clock {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 3: ours alone, and the submission that used it is done or never began.
        unsafe { self.context.raw().destroy_query_pool(self.raw, None) }
    }
}

/// The difference of two counters of so many bits, the second of which may have wrapped round.
fn ticks_between([start, end]: [u64; 2], bits: u32) -> u64 {
    let mask = u64::MAX.checked_shr(64 - bits.min(64)).unwrap_or(0);
    end.wrapping_sub(start) & mask
}

#[cfg(test)]
mod tests {
    use super::ticks_between;

    #[test]
    fn a_counter_may_wrap_round() {
        assert_eq!(ticks_between([10, 25], 64), 15);
        assert_eq!(ticks_between([u64::MAX - 1, 3], 64), 5);
        assert_eq!(ticks_between([(1 << 36) - 2, 4], 36), 6);
    }
}
