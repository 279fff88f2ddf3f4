//! Records of when dispatches ran.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

/// Clocks that can time a dispatch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// The device's clock, by timestamp queries.
    Device,
    /// The host's clock, which times whole submissions only.
    Host,
}

/// One dispatch of a submission.
#[derive(Debug, Clone, PartialEq)]
pub struct DispatchTime {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Workgroups along each axis.
    pub workgroups: [u32; 3],
    /// Begin and end by the device's clock, counted from the begin of the submission; `None` where dispatches are not
    /// timed.
    pub span: Option<(Duration, Duration)>,
}

/// One submission.
#[derive(Debug, Clone, PartialEq)]
pub struct SubmissionTime {
    /// Label of the submission.
    pub label: String,
    /// Time when the work was handed over, counted from the begin of the record, by the host's clock.
    pub begin: Duration,
    /// Time from handing the work over to knowing it done, by the host's clock.
    pub wall: Duration,
    /// Dispatches of the submission, in order.
    pub dispatches: Vec<DispatchTime>,
}

/// Record of a context's submissions, where one is kept.
#[derive(Default)]
pub(super) struct TimingRecord(Mutex<Option<Running>>);

struct Running {
    epoch: Instant,
    clock: Clock,
    submissions: Vec<SubmissionTime>,
}

impl TimingRecord {
    /// Discards the record and begins a new one.
    pub(super) fn start(&self, clock: Clock) {
        *self.lock() = Some(Running { epoch: Instant::now(), clock, submissions: Vec::new() });
    }

    /// Discards the record and begins none.
    pub(super) fn stop(&self) {
        *self.lock() = None;
    }

    /// Clock in use; `None` where no record is kept.
    pub(super) fn clock(&self) -> Option<Clock> {
        self.lock().as_ref().map(|running| running.clock)
    }

    /// Adds a submission that was handed over at `begin`.
    pub(super) fn add(&self, label: &str, begin: Instant, wall: Duration, dispatches: Vec<DispatchTime>) {
        if let Some(running) = self.lock().as_mut() {
            let begin = begin.saturating_duration_since(running.epoch);
            running.submissions.push(SubmissionTime { label: label.into(), begin, wall, dispatches });
        }
    }

    /// Submissions added since the last call.
    pub(super) fn take(&self) -> Vec<SubmissionTime> {
        self.lock().as_mut().map(|running| std::mem::take(&mut running.submissions)).unwrap_or_default()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Running>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
