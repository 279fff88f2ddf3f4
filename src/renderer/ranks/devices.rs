//! Devices of one process that work at the same time.
//!
//! Devices never wait for each other: the first one starts the work of the others as threads and joins them. A device that fails
//! ends its thread, so nobody hangs.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::renderer::Renderer;
use crate::renderer::statistics::Counts;
use crate::{Error, Result};

/// Longest time between two questions whether to stop, while the first device waits for the others.
const PATIENCE: Duration = Duration::from_millis(5);

impl Renderer {
    /// The devices of this process.
    pub(super) fn all(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.others)
    }

    /// Adds `batch` samples to every pixel of this process's share of the film, on all its devices at the same time. Where `stop`
    /// answers true or a device fails, all devices end after their dispatches under way. Returns whether all samples were taken.
    pub(super) fn trace_on_devices(
        &mut self,
        batch: u32,
        first_of_sets: u32,
        counts: &mut Counts,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool> {
        if self.others.is_empty() {
            return self.trace_share(batch, first_of_sets, counts, stop);
        }
        let samples_done = self.samples_done;
        let mut others = std::mem::take(&mut self.others);
        let is_ended = AtomicBool::new(false);
        let ends = |traced: &Result<bool>| {
            if !matches!(traced, Ok(true)) {
                is_ended.store(true, Ordering::Relaxed);
            }
        };
        let first_thread = thread::current();
        let start = |other: &mut Self| {
            let mut counts = Counts::default();
            other.samples_done = samples_done;
            let is_ended = || is_ended.load(Ordering::Relaxed);
            let traced = other.trace_share(batch, first_of_sets, &mut counts, &is_ended);
            ends(&traced);
            first_thread.unpark();
            (traced.map_err(|error| other.named(error)), counts)
        };
        let (own, joined) = thread::scope(|scope| {
            let start = &start;
            let threads: Vec<_> = others.iter_mut().map(|other| scope.spawn(move || start(other))).collect();
            let own = self.trace_share(batch, first_of_sets, counts, &|| is_ended.load(Ordering::Relaxed) || stop());
            ends(&own);
            while !threads.iter().all(thread::ScopedJoinHandle::is_finished) {
                if stop() {
                    is_ended.store(true, Ordering::Relaxed);
                }
                thread::park_timeout(PATIENCE);
            }
            let joined = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
            (own, joined.collect::<Vec<_>>())
        });
        self.others = others;
        let mut is_complete = own?;
        for (traced, of_device) in joined {
            is_complete &= traced?;
            counts.add(&of_device);
        }
        for other in &mut self.others {
            other.samples_done = samples_done + batch;
        }
        Ok(is_complete)
    }

    /// Does something on all devices of this process at the same time.
    pub(in crate::renderer) fn on_every_device(&mut self, act: &(dyn Fn(&Self) -> Result<()> + Sync)) -> Result<()> {
        let mut others = std::mem::take(&mut self.others);
        let start = |other: &mut Self| act(other).map_err(|error| other.named(error));
        let done: Vec<Result<()>> = thread::scope(|scope| {
            let start = &start;
            let threads: Vec<_> = others.iter_mut().map(|other| scope.spawn(move || start(other))).collect();
            let own = act(self);
            let joined = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
            let joined: Vec<_> = joined.collect();
            std::iter::once(own).chain(joined).collect()
        });
        self.others = others;
        done.into_iter().collect()
    }

    /// An error that names this device.
    pub(super) fn named(&self, error: Error) -> Error {
        let device = self.context.device();
        error.during(&format!("device {} ({})", device.index, device.name))
    }
}
