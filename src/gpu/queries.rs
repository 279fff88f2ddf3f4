//! Timestamp queries: times by the device's own clock.

use std::time::Duration;

use ash::vk;

use super::device::LogicalDevice;

/// Most dispatches of one submission that are timed one by one.
const TIMED_DISPATCHES: u32 = 32;

/// Number of queries in a pool: two for the whole submission, two for each dispatch.
pub(super) const QUERY_COUNT: u32 = 2 + 2 * TIMED_DISPATCHES;

/// Timestamps around a command buffer's work, and around each of its first dispatches where asked for.
pub(super) struct Timestamps<'a> {
    raw: vk::QueryPool,
    device: &'a LogicalDevice,
}

impl<'a> Timestamps<'a> {
    /// Timestamps in a pool of [`QUERY_COUNT`] queries, which belongs to the caller while this value lives.
    pub(super) fn new(device: &'a LogicalDevice, raw: vk::QueryPool) -> Self {
        Self { raw, device }
    }

    /// Records the start of all work.
    pub(super) fn start(&self, commands: vk::CommandBuffer) {
        // SAFETY: invariants 1 and 3: the recorder owns the queries and the command buffer, which is being recorded.
        unsafe { self.device.raw().cmd_reset_query_pool(commands, self.raw, 0, QUERY_COUNT) };
        self.write(commands, vk::PipelineStageFlags::TOP_OF_PIPE, 0);
    }

    /// Records the end of all work.
    pub(super) fn stop(&self, commands: vk::CommandBuffer) {
        self.write(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, 1);
    }

    /// Records the start of dispatch number `place`: the time when all work before it is done.
    pub(super) fn start_dispatch(&self, commands: vk::CommandBuffer, place: usize) {
        self.write_dispatch(commands, place, 0);
    }

    /// Records the end of dispatch number `place`.
    pub(super) fn stop_dispatch(&self, commands: vk::CommandBuffer, place: usize) {
        self.write_dispatch(commands, place, 1);
    }

    fn write_dispatch(&self, commands: vk::CommandBuffer, place: usize, end: u32) {
        let query = u32::try_from(place).unwrap_or(TIMED_DISPATCHES).saturating_mul(2).saturating_add(2 + end);
        if query < QUERY_COUNT {
            self.write(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, query);
        }
    }

    fn write(&self, commands: vk::CommandBuffer, stage: vk::PipelineStageFlags, query: u32) {
        // SAFETY: invariants 1 and 3: the recorder owns the queries and the command buffer, which is being recorded;
        // the pool has this query.
        unsafe { self.device.raw().cmd_write_timestamp(commands, stage, self.raw, query) }
    }

    /// Time between start and end, once the submission is done.
    pub(super) fn elapsed(&self) -> Option<Duration> {
        let [start, end] = self.ticks(0)?;
        Some(self.between(start, end))
    }

    /// Begin and end of dispatch number `place`, counted from the start of all work, once the submission is done.
    /// `None` where the dispatch was not timed.
    pub(super) fn span(&self, place: usize) -> Option<(Duration, Duration)> {
        let query = u32::try_from(place).ok()?.checked_mul(2)?.checked_add(2)?;
        if query >= QUERY_COUNT {
            return None;
        }
        let ([zero, _], [start, end]) = (self.ticks(0)?, self.ticks(query)?);
        Some((self.between(zero, start), self.between(zero, end)))
    }

    /// Ticks of query number `query` and of the next one.
    fn ticks(&self, query: u32) -> Option<[u64; 2]> {
        let mut ticks = [0_u64; 2];
        // SAFETY: invariant 1: device and queries are alive, and the slice has room for both.
        let result = unsafe {
            self.device.raw().get_query_pool_results(self.raw, query, &mut ticks, vk::QueryResultFlags::TYPE_64)
        };
        result.ok().map(|()| ticks)
    }

    fn between(&self, start: u64, end: u64) -> Duration {
        let period = f64::from(self.device.info().limits.timestamp_nanoseconds);
        let ticks = ticks_between([start, end], self.device.timestamp_bits());
        Duration::from_secs_f64(ticks as f64 * period * 1e-9)
    }
}

/// Difference of two counters of `bits` bits. The second may have wrapped around.
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
