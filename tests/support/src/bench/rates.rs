//! Durations of work, and the maximum rates of a device, measured by small kernels that each do one kind of work.

use std::sync::Arc;
use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use lodestar::generated::kernels::{Variant, test};
use lodestar::gpu::{Buffer, Kernel, Submission};

use crate::device::{Device, GROUP};

/// Multiplications and additions in a round of `glsl/test/arithmetic.comp`.
const OPERATIONS_PER_ROUND: u32 = 192;
const ARITHMETIC_ROUNDS: u32 = 128;
const ARITHMETIC_GROUPS: u32 = 1024;

/// Seconds of a submission, by the device's clock if it has one.
pub fn seconds_of(submission: Submission) -> f64 {
    submission.device.unwrap_or(submission.wall).as_secs_f64()
}

/// Repeats `once` for at least the given seconds. Returns the mean of the seconds that it returns.
pub fn mean_seconds(at_least: f64, mut once: impl FnMut() -> f64) -> f64 {
    let (begin, mut sum, mut runs) = (Instant::now(), 0.0, 0);
    while runs == 0 || begin.elapsed().as_secs_f64() < at_least {
        sum += once();
        runs += 1;
    }
    sum / f64::from(runs)
}

/// Push constants of the small kernels.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    rounds: u32,
    other: u32,
}

/// Single-precision additions and multiplications.
pub struct Arithmetic {
    device: Arc<Device>,
    kernel: Kernel,
    results: Arc<Buffer>,
}

impl Arithmetic {
    pub fn new(device: &Arc<Device>) -> Self {
        let results = device.storage("results", (ARITHMETIC_GROUPS * GROUP) as usize * 4);
        let kernel = device.kernel(&test::ARITHMETIC, &Variant::default());
        Self { device: Arc::clone(device), kernel, results }
    }

    /// Operations per second, measured for at least the given seconds.
    pub fn rate(&self, seconds: f64) -> f64 {
        let push = ARITHMETIC_ROUNDS;
        let once = || {
            let bytes = bytemuck::bytes_of(&push);
            seconds_of(self.device.dispatch(&self.kernel, &[&self.results], bytes, ARITHMETIC_GROUPS))
        };
        let operations = f64::from(ARITHMETIC_GROUPS * GROUP) * f64::from(ARITHMETIC_ROUNDS * OPERATIONS_PER_ROUND);
        operations / mean_seconds(seconds, once)
    }
}

/// Size of a node of the hierarchy, in bytes.
pub const NODE_BYTES: u32 = 80;
const FETCH_ROUNDS: u32 = 64;
const FETCH_GROUPS: u32 = 256;

/// Independent reads of whole nodes, in the way in which the traversal reads them.
pub struct Fetches {
    device: Arc<Device>,
    kernel: Kernel,
    results: Arc<Buffer>,
}

impl Fetches {
    pub fn new(device: &Arc<Device>) -> Self {
        let results = device.storage("results", (FETCH_GROUPS * GROUP) as usize * 4);
        let kernel = device.kernel(&test::GATHER, &Variant::default());
        Self { device: Arc::clone(device), kernel, results }
    }

    /// Bytes per second for random nodes among the first `node_count` of a buffer, measured for at least the given
    /// seconds.
    pub fn rate(&self, nodes: &Arc<Buffer>, node_count: u32, seconds: f64) -> f64 {
        let push = Push { rounds: FETCH_ROUNDS, other: node_count };
        let once = || {
            let bytes = bytemuck::bytes_of(&push);
            seconds_of(self.device.dispatch(&self.kernel, &[&self.results, nodes], bytes, FETCH_GROUPS))
        };
        f64::from(FETCH_GROUPS * GROUP) * f64::from(FETCH_ROUNDS * NODE_BYTES) / mean_seconds(seconds, once)
    }
}

const COPY_ROUNDS: u32 = 16;

/// Copies of words from one buffer to another.
pub struct Copies {
    device: Arc<Device>,
    kernel: Kernel,
    from: Arc<Buffer>,
    to: Arc<Buffer>,
    groups: u32,
}

impl Copies {
    /// Copies that read and write about the given number of bytes in total.
    pub fn new(device: &Arc<Device>, bytes: u64) -> Self {
        let groups = (bytes / 2).div_ceil(u64::from(4 * COPY_ROUNDS * GROUP)) as u32;
        let buffer = |name| device.storage(name, (groups * GROUP * COPY_ROUNDS * 4) as usize);
        let kernel = device.kernel(&test::COPY, &Variant::default());
        Self { device: Arc::clone(device), kernel, from: buffer("from"), to: buffer("to"), groups }
    }

    /// Bytes per second, read and written, measured for at least the given seconds.
    pub fn rate(&self, seconds: f64) -> f64 {
        let push = Push { rounds: COPY_ROUNDS, other: self.groups * GROUP };
        let once = || {
            let bytes = bytemuck::bytes_of(&push);
            seconds_of(self.device.dispatch(&self.kernel, &[&self.from, &self.to], bytes, self.groups))
        };
        2.0 * self.from.len_bytes() as f64 / mean_seconds(seconds, once)
    }
}
