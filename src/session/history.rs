//! History of a render: the steps that it has taken.

use serde::{Deserialize, Serialize};

use crate::renderer::Counts;
use crate::session::statistics::StepStatistics;

/// The steps of a render so far and their sums.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// Seconds of rendering.
    pub seconds: f64,
    /// Paths traced.
    pub paths: u64,
    /// Sums of the kernels' counters.
    pub counts: Counts,
    /// The steps in order.
    pub steps: Vec<StepStatistics>,
}

impl History {
    /// Clause of an error message that names the last good step.
    pub(super) fn last_good_step(&self) -> String {
        match self.steps.len() {
            0 => "no step had ended".to_owned(),
            count => {
                let samples = self.steps.iter().fold(0, |sum: u64, step| sum.saturating_add(step.spp));
                format!("the last good step is number {count}, which ended at {samples} samples per pixel")
            }
        }
    }
}
