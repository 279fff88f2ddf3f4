//! What was measured of one method on one scene, kept on disk so that nothing is measured twice.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::files;
use crate::image::metrics::Metrics;
use crate::renderer::{Counts, StepReport};
use crate::settings::Settings;
use crate::{Error, Result};

/// What a measurement depends on. Another one is measured anew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Lodestar's version.
    pub version: String,
    /// Device and driver.
    pub device: String,
    /// Hash of the scene.
    pub scene_hash: String,
    /// Hash of the reference.
    pub reference_hash: String,
    /// Seconds of rendering that every method has.
    pub budget: f64,
    /// The settings of the render.
    pub settings: Value,
}

/// One step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepRecord {
    /// Samples per pixel so far.
    pub spp: u32,
    /// Seconds so far.
    pub seconds: f64,
    /// Share of the step's scattered rays that met light (Fig. 7a).
    pub light_hit_rate: f64,
    /// MAE of the displayed picture so far; measured after steps 1, 2, 4, 8, ...
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mae: Option<f64>,
}

/// Memory that a method takes besides film and scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Bytes of the guide's grids.
    pub guide_bytes: u64,
    /// Bytes of the vertices that the learner keeps of each path under way.
    pub path_bytes: u64,
}

/// One method on one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// What it depends on.
    pub conditions: Conditions,
    /// The scene's name.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// The picture's width in pixels.
    pub width: u32,
    /// The picture's height in pixels.
    pub height: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// Seconds of rendering and learning.
    pub seconds: f64,
    /// Error against the reference.
    pub errors: Metrics,
    /// What all steps counted.
    pub counts: Counts,
    /// What the guide takes.
    pub memory: Memory,
    /// The steps one by one.
    pub steps: Vec<StepRecord>,
}

impl Record {
    /// Milliseconds per sample per pixel, for the whole picture.
    pub fn ms_per_sample(&self) -> f64 {
        1000.0 * self.seconds / f64::from(self.spp.max(1))
    }

    /// Reads a record; nothing where the file is not there, or is not one of these conditions.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn read(path: &Path, conditions: &Conditions) -> Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        let text = fs::read_to_string(path).map_err(Error::read(path))?;
        let record: Option<Self> = serde_json::from_str(&text).ok();
        Ok(record.filter(|record| record.conditions == *conditions))
    }

    /// Writes it, whole.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        files::write_json(path, self)
    }
}

impl StepRecord {
    /// The step that a report tells of, which ended at so many samples and seconds.
    pub fn new(report: &StepReport, spp: u32, seconds: f64) -> Self {
        Self { spp, seconds, light_hit_rate: report.counts.light_hit_rate(), mae: None }
    }
}

/// Settings as a record keeps them.
pub fn settings_value(settings: &Settings) -> Value {
    // All fields are plain numbers and words, which JSON takes.
    serde_json::to_value(settings).unwrap_or_default()
}
