//! Records: measurements of one method on one scene. They are stored on disk, so that nothing is measured twice.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::files;
use crate::image::metrics::Metrics;
use crate::renderer::{Counts, StepReport};
use crate::settings::Settings;
use crate::{Error, Result};

/// Conditions of a measurement. If one of them differs, the method is measured again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Version of Lodestar.
    pub version: String,
    /// Device and driver.
    pub device: String,
    /// Hash of the scene.
    pub scene_hash: String,
    /// Hash of the reference.
    pub reference_hash: String,
    /// Rendering time of every method, in seconds.
    pub budget: f64,
    /// Settings of the render.
    pub settings: Value,
}

/// Measurements after one step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepRecord {
    /// Samples per pixel so far.
    pub spp: u32,
    /// Rendering time so far, in seconds.
    pub seconds: f64,
    /// Share of the step's scattered rays that hit an emitter (Figure 7a).
    pub light_hit_rate: f64,
    /// MAE of the displayed picture so far, measured after steps 1, 2, 4, 8, ...
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mae: Option<f64>,
}

/// Memory of a method, without film and scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Bytes of the guide's grids.
    pub guide_bytes: u64,
    /// Bytes of the vertices that the learner keeps for each path.
    pub path_bytes: u64,
}

/// Measurements of one method on one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Conditions of the measurement.
    pub conditions: Conditions,
    /// Name of the scene.
    pub scene: String,
    /// Name of the method.
    pub method: String,
    /// Width of the picture, in pixels.
    pub width: u32,
    /// Height of the picture, in pixels.
    pub height: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// Time of rendering and learning, in seconds.
    pub seconds: f64,
    /// Error against the reference.
    pub errors: Metrics,
    /// Statistics, summed over all steps.
    pub counts: Counts,
    /// Memory of the guide.
    pub memory: Memory,
    /// Measurements after each step.
    pub steps: Vec<StepRecord>,
}

impl Record {
    /// Milliseconds per sample per pixel, for the whole picture.
    pub fn ms_per_sample(&self) -> f64 {
        1000.0 * self.seconds / f64::from(self.spp.max(1))
    }

    /// Reads a record. Returns `None` if the file does not exist or was measured under other conditions.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn read(path: &Path, conditions: &Conditions) -> Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        let text = fs::read_to_string(path).map_err(Error::read(path))?;
        let record: Option<Self> = serde_json::from_str(&text).ok();
        Ok(record.filter(|record| record.conditions == *conditions))
    }

    /// Writes the record in one piece, so that no half-written file remains.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        files::write_json(path, self)
    }
}

impl StepRecord {
    /// Measurements after the step of `report`, at the given samples per pixel and seconds.
    pub fn new(report: &StepReport, spp: u32, seconds: f64) -> Self {
        Self { spp, seconds, light_hit_rate: report.counts.light_hit_rate(), mae: None }
    }
}

/// Settings in the form in which a record stores them.
pub fn settings_value(settings: &Settings) -> Value {
    // The conversion cannot fail: all fields are plain numbers and words.
    serde_json::to_value(settings).unwrap_or_default()
}
