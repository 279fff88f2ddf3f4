//! Quantity that the baseline measures: one line of the table.

use serde_json::Value;

/// Quantity that is measured.
pub struct Quantity {
    pub name: String,
    pub unit: Unit,
    pub place: Place,
    /// Runs the work one or several times and returns the seconds for one time; NaN if they cannot be measured.
    pub run: Box<dyn FnMut() -> f64>,
    /// Request for Mitsuba to measure the same work.
    pub request: Option<Value>,
}

/// Unit in which a time is expressed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unit {
    /// Millions of things per second: the number of millions in the measured time, and the name of the things.
    MillionsPerSecond(f64, &'static str),
    Seconds,
    Milliseconds,
}

/// Place where the work runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    Device,
    /// All threads of the processor.
    Host,
}

impl Unit {
    pub fn name(self) -> String {
        match self {
            Self::MillionsPerSecond(_, what) => format!("M{what}/s"),
            Self::Seconds => "s".into(),
            Self::Milliseconds => "ms".into(),
        }
    }

    pub fn value(self, seconds: f64) -> f64 {
        match self {
            Self::MillionsPerSecond(millions, _) => millions / seconds,
            Self::Seconds => seconds,
            Self::Milliseconds => 1.0e3 * seconds,
        }
    }

    /// Number that is larger for faster work: a rate, or the inverse of a time.
    pub fn speed(self, seconds: f64) -> f64 {
        match self {
            Self::MillionsPerSecond(..) => self.value(seconds),
            Self::Seconds | Self::Milliseconds => 1.0 / self.value(seconds),
        }
    }
}
