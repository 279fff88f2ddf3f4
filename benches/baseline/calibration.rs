//! Calibration: fixed pieces of work that measure the current speed of the machine.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use support::bench::rates::{Arithmetic, mean_seconds};
use support::device::Device;

use crate::quantity::Place;

/// Minimum time for which each piece of work is repeated, in seconds.
const SECONDS: f64 = 0.04;
/// Number of links of the chain that every thread computes.
const LINKS: u32 = 1 << 20;

/// Calibrating work on the device and on the processor's threads.
pub struct Calibration {
    arithmetic: Arithmetic,
}

impl Calibration {
    pub fn new(device: &Arc<Device>) -> Self {
        Self { arithmetic: Arithmetic::new(device) }
    }

    /// Speed of the calibrating work, in 10^9 operations per second.
    pub fn rate(&self, place: Place) -> f64 {
        match place {
            Place::Device => self.arithmetic.rate(SECONDS) / 1.0e9,
            Place::Host => host_rate(SECONDS) / 1.0e9,
        }
    }
}

/// Links per second, summed over all threads.
fn host_rate(seconds: f64) -> f64 {
    let once = || {
        let begin = Instant::now();
        rayon::broadcast(|thread| black_box(chain(thread.index() as u64)));
        begin.elapsed().as_secs_f64()
    };
    f64::from(LINKS) * rayon::current_num_threads() as f64 / mean_seconds(seconds, once)
}

/// Chain of dependent integer multiplications and shifts, which no compiler can shorten.
fn chain(seed: u64) -> u64 {
    (0..LINKS).fold(seed, |x, i| (x ^ u64::from(i)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23))
}
