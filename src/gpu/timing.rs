//! When dispatches ran, for those who ask.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

/// Whose clock tells when a dispatch ran.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clock {
    /// The device's, by timestamp queries.
    Device,
    /// The host's, which sees whole submissions only.
    Host,
}

/// One dispatch of a submission.
#[derive(Debug, Clone, PartialEq)]
pub struct DispatchTime {
    /// The kernel's name.
    pub kernel: &'static str,
    /// Workgroups along each axis.
    pub workgroups: [u32; 3],
    /// Begin and end, from the submission's begin by the device's clock; nothing where that was not asked.
    pub span: Option<(Duration, Duration)>,
}

/// One submission.
#[derive(Debug, Clone, PartialEq)]
pub struct SubmissionTime {
    /// Its label.
    pub label: String,
    /// When it was handed over, from the begin of the record, by the host's clock.
    pub begin: Duration,
    /// Until it was known to be done, by the host's clock.
    pub wall: Duration,
    /// Its dispatches, in order.
    pub dispatches: Vec<DispatchTime>,
}

/// A context's record of submissions, if one is kept.
#[derive(Default)]
pub(super) struct TimingRecord(Mutex<Option<Running>>);

struct Running {
    epoch: Instant,
    clock: Clock,
    submissions: Vec<SubmissionTime>,
}

impl TimingRecord {
    /// Forgets what was recorded and begins anew.
    pub(super) fn start(&self, clock: Clock) {
        *self.lock() = Some(Running { epoch: Instant::now(), clock, submissions: Vec::new() });
    }

    /// Whose clock is used, if a record is kept.
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

    /// What was added since the last call.
    pub(super) fn take(&self) -> Vec<SubmissionTime> {
        self.lock().as_mut().map(|running| std::mem::take(&mut running.submissions)).unwrap_or_default()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Running>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
