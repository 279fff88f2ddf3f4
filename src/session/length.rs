//! When a render ends.

use serde::{Deserialize, Serialize};

use crate::settings::Settings;
use crate::{Error, Result};

/// What ends a render: the samples or the time, whichever is reached first. A render with neither goes on until noise or its
/// caller ends it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Length {
    /// Samples per pixel.
    pub spp: Option<u32>,
    /// Seconds of rendering, those before a checkpoint included.
    pub seconds: Option<f64>,
}

impl Length {
    /// Whether a limit is given.
    pub(super) fn is_given(&self) -> bool {
        self.spp.is_some() || self.seconds.is_some()
    }

    /// Samples per pixel until the render ends, or until their 32-bit numbers end.
    pub(super) fn samples_left(&self, settings: &Settings, samples_done: u32) -> u32 {
        let most = u32::MAX - settings.sample_offset.unwrap_or(0);
        self.spp.unwrap_or(most).saturating_sub(samples_done)
    }

    /// Share of the render that is done, in [0, 1], by samples or by time, whichever is further.
    pub(super) fn fraction(&self, samples_done: u32, seconds: f64) -> f64 {
        let by_samples = self.spp.map_or(0.0, |target| f64::from(samples_done) / f64::from(target));
        let by_time = self.seconds.map_or(0.0, |limit| seconds / limit);
        by_samples.max(by_time).min(1.0)
    }

    /// Refuses more samples than 32-bit numbers can tell apart.
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
