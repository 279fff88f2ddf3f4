//! Limits that end a render.

use serde::{Deserialize, Serialize};

use crate::settings::Settings;
use crate::{Error, Result};

/// Limits of a render: the one that is reached first ends it. A render without limits goes on until noise or its caller ends it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Length {
    /// Number of samples per pixel.
    pub spp: Option<u32>,
    /// Seconds of rendering, including the seconds before a checkpoint.
    pub seconds: Option<f64>,
}

impl Length {
    /// Whether a limit is given.
    pub(super) fn is_given(&self) -> bool {
        self.spp.is_some() || self.seconds.is_some()
    }

    /// Samples per pixel that are left. A render without a limit ends where the 32-bit sample numbers end.
    pub(super) fn samples_left(&self, settings: &Settings, samples_done: u32) -> u32 {
        let most = u32::MAX - settings.sample_offset.unwrap_or(0);
        self.spp.unwrap_or(most).saturating_sub(samples_done)
    }

    /// Share of the render that is done, in [0, 1]: the larger one of its share of the samples and of the time.
    pub(super) fn fraction(&self, samples_done: u32, seconds: f64) -> f64 {
        let by_samples = self.spp.map_or(0.0, |target| f64::from(samples_done) / f64::from(target));
        let by_time = self.seconds.map_or(0.0, |limit| seconds / limit);
        by_samples.max(by_time).min(1.0)
    }

    /// Refuses a render whose sample numbers do not fit 32 bits.
    pub(super) fn check_sample_range(&self, settings: &Settings) -> Result<()> {
        let offset = settings.sample_offset.unwrap_or(0);
        match offset.checked_add(self.spp.unwrap_or(0)) {
            Some(_) => Ok(()),
            None => {
                Err(Error::Settings(format!("--sample-offset {offset} and --spp add up to more than 2^32 samples")))
            }
        }
    }
}
