//! Storage of baselines in files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::rounds::Measured;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/baselines");

/// Measurements on one machine.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Baseline {
    pub machine: Machine,
    /// Load of the machine ([`crate::machine::load`]) before the first round.
    pub load: Option<f64>,
    pub rounds: usize,
    /// Quantities in the order of the table.
    pub quantities: Vec<Line>,
}

/// Measurement of one quantity. Numbers that could not be measured are absent.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Line {
    pub name: String,
    pub unit: String,
    pub value: Option<f64>,
    pub least: Option<f64>,
    pub most: Option<f64>,
    pub calibrated_speed: Option<f64>,
    pub calibration: Option<f64>,
    pub mitsuba: Option<f64>,
    pub relative_to_mitsuba: Option<f64>,
}

impl Line {
    /// Whether a larger value is better.
    pub fn is_rate(&self) -> bool {
        self.unit.ends_with("/s")
    }

    /// Speed relative to another value of the same unit; `None` if one of them is missing.
    pub fn speed_ratio(&self, other: &Self) -> Option<f64> {
        let ratio = self.value? / other.value?;
        (self.unit == other.unit).then_some(if self.is_rate() { ratio } else { 1.0 / ratio })
    }

    /// Speed relative to another value, both relative to the calibrating work.
    pub fn corrected_ratio(&self, other: &Self) -> Option<f64> {
        let ratio = self.calibrated_speed? / other.calibrated_speed?;
        (self.unit == other.unit).then_some(ratio)
    }
}

impl From<&Measured> for Line {
    fn from(measured: &Measured) -> Self {
        // Six digits exceed the precision of a measurement.
        let some = |x: f64| x.is_finite().then(|| format!("{x:.5e}").parse().unwrap_or(x));
        Self {
            name: measured.name.clone(),
            unit: measured.unit.clone(),
            value: some(measured.value),
            least: some(measured.least),
            most: some(measured.most),
            calibrated_speed: some(measured.calibrated_speed),
            calibration: some(measured.calibration),
            mitsuba: some(measured.mitsuba),
            relative_to_mitsuba: some(measured.relative_to_mitsuba),
        }
    }
}

impl Baseline {
    pub fn new(machine: Machine, load: Option<f64>, rounds: usize, measured: &[Measured]) -> Self {
        Self { machine, load, rounds, quantities: measured.iter().map(Line::from).collect() }
    }

    /// Reads the baseline that is stored for a machine. Prints why there is none, or which conditions differ.
    pub fn of_machine(machine: &Machine) -> Option<Self> {
        let path = Path::new(FOLDER).join(machine.file_name());
        let Ok(text) = std::fs::read_to_string(&path) else {
            println!("\nno baseline is stored for this device, processor and number of threads; --store writes one");
            others().iter().for_each(|name| println!("  not compared with: {name}"));
            return None;
        };
        let stored: Self = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        if stored.machine.driver != machine.driver {
            println!("\nthe baseline was measured with another driver: {}", stored.machine.driver);
        }
        println!("\nthe baseline was measured with build {}:", stored.machine.commit);
        stored.machine.warn_of_load(stored.load);
        Some(stored)
    }

    pub fn lines(&self) -> BTreeMap<&str, &Line> {
        self.quantities.iter().map(|line| (line.name.as_str(), line)).collect()
    }

    /// Replaces the baseline that is stored for the machine.
    pub fn write(&self) -> PathBuf {
        let path = Path::new(FOLDER).join(self.machine.file_name());
        std::fs::create_dir_all(FOLDER).expect("the folder of baselines");
        let text = serde_json::to_string_pretty(self).expect("JSON");
        std::fs::write(&path, text + "\n").expect("the baseline is written");
        path
    }
}

/// Names of all stored baselines.
fn others() -> Vec<String> {
    let entries = std::fs::read_dir(FOLDER).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
