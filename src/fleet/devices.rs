//! Devices of one process that work at the same time.
//!
//! Devices never wait for each other: the first one starts the work of the others as threads and joins them. A device that fails
//! ends its thread, so nobody hangs.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

use crate::Result;
use crate::fleet::Fleet;
use crate::renderer::phases::Batch;
use crate::renderer::{Counts, Renderer};

/// Longest time between two questions whether to stop, while the first device waits for the others.
const PATIENCE: Duration = Duration::from_millis(5);

/// How a device has traced its share of a batch.
struct Traced {
    /// Whether all samples were taken.
    is_complete: Result<bool>,
    counts: Counts,
    seconds: f64,
}

impl Traced {
    fn by(device: &Renderer, batch: Batch, stop: &dyn Fn() -> bool) -> Self {
        let (begin, mut counts) = (Instant::now(), Counts::default());
        let is_complete = device.trace(batch, &mut counts, stop);
        Self { is_complete, counts, seconds: begin.elapsed().as_secs_f64() }
    }
}

impl Fleet {
    /// Adds a batch of samples to every pixel of this process's share of the film, on all its devices at the same time. Where
    /// `stop` answers true or a device fails, all devices end after their dispatches under way. Returns whether all samples were
    /// taken.
    pub(super) fn trace_on_devices(
        &mut self,
        batch: Batch,
        counts: &mut Counts,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool> {
        self.traced_by_devices(batch, stop).into_iter().try_fold(true, |is_complete, traced| {
            counts.add(&traced.counts);
            Ok(is_complete & traced.is_complete?)
        })
    }

    /// Seconds that each device of this process takes for its share of a batch.
    pub(super) fn seconds_of_devices(&mut self, batch: Batch) -> Result<Vec<f64>> {
        let traced = self.traced_by_devices(batch, &|| false);
        traced.into_iter().map(|traced| traced.is_complete.map(|_| traced.seconds)).collect()
    }

    fn traced_by_devices(&mut self, batch: Batch, stop: &dyn Fn() -> bool) -> Vec<Traced> {
        let is_ended = &AtomicBool::new(false);
        let first_thread = thread::current();
        let trace = move |device: &mut Renderer, stop: &dyn Fn() -> bool| {
            let traced = Traced::by(device, batch, &|| is_ended.load(Ordering::Relaxed) || stop());
            if !matches!(traced.is_complete, Ok(true)) {
                is_ended.store(true, Ordering::Relaxed);
            }
            traced
        };
        let start = |other: &mut Renderer| {
            let traced = trace(other, &|| false);
            first_thread.unpark();
            Traced { is_complete: traced.is_complete.map_err(|error| other.named(error)), ..traced }
        };
        let Self { first, others, .. } = self;
        thread::scope(|scope| {
            let start = &start;
            let threads: Vec<_> = others.iter_mut().map(|other| scope.spawn(move || start(other))).collect();
            let own = trace(first, stop);
            while !threads.iter().all(ScopedJoinHandle::is_finished) {
                if stop() {
                    is_ended.store(true, Ordering::Relaxed);
                }
                thread::park_timeout(PATIENCE);
            }
            joined(own, threads)
        })
    }

    /// Does something on all devices of this process at the same time.
    pub(super) fn on_every_device(&mut self, act: impl Fn(&Renderer) -> Result<()> + Sync) -> Result<()> {
        let Self { first, others, .. } = self;
        let start = |other: &mut Renderer| act(other).map_err(|error| other.named(error));
        let done = thread::scope(|scope| {
            let start = &start;
            let threads: Vec<_> = others.iter_mut().map(|other| scope.spawn(move || start(other))).collect();
            let own = act(first);
            joined(own, threads)
        });
        done.into_iter().collect()
    }
}

/// Results of the first device and of the others' threads.
fn joined<T>(first: T, others: Vec<ScopedJoinHandle<'_, T>>) -> Vec<T> {
    let others = others.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
    std::iter::once(first).chain(others).collect()
}
