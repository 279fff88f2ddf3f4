//! Times of the work that devices do only because they share a film.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use serde::{Deserialize, Serialize};

/// Seconds that several devices have spent on sharing a film.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SharingTimes {
    /// Number of ranks.
    pub ranks: usize,
    /// Number of devices of all ranks.
    pub devices: usize,
    /// Adding up the sums of learning targets, and handing them to all devices.
    pub exchange_seconds: f64,
    /// Copying the film's tiles to the first device of the first rank.
    pub gather_seconds: f64,
    /// Waiting of the first rank, after its own work, for the other ranks.
    pub waiting_seconds: f64,
    /// Number of exchanges of sums.
    pub exchanges: u64,
    /// Mean number of bytes that a rank or a device hands to the others in one exchange. Ranks leave out blocks of bins in which no
    /// rank has a learning target.
    pub exchange_bytes: u64,
}

/// Number of exchanges, and bytes of all of them.
#[derive(Debug, Default)]
pub(super) struct Traffic {
    exchanges: AtomicU64,
    bytes: AtomicU64,
}

impl Traffic {
    /// Counts an exchange of so many bytes.
    pub fn note(&self, bytes: usize) {
        self.exchanges.fetch_add(1, Ordering::Relaxed);
        self.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// Number of exchanges.
    pub fn exchanges(&self) -> u64 {
        self.exchanges.load(Ordering::Relaxed)
    }

    /// Mean number of bytes of an exchange. 0 without exchanges.
    pub fn mean_bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed).checked_div(self.exchanges()).unwrap_or(0)
    }
}

/// Clock that adds up times of work in nanoseconds.
#[derive(Debug, Default)]
pub(super) struct Clock(AtomicU64);

impl Clock {
    /// Does some work and adds its time.
    pub fn time<T>(&self, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let done = work();
        self.0.fetch_add(begin.elapsed().as_nanos() as u64, Ordering::Relaxed);
        done
    }

    /// Sum of the times.
    pub fn seconds(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1.0e-9
    }
}
