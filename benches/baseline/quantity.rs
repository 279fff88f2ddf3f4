//! One line of the table.

use serde_json::Value;

/// Something that is measured.
pub struct Quantity {
    pub name: String,
    pub unit: Unit,
    pub place: Place,
    /// Does it once, or some times, and returns the seconds that one time takes; not a number where it cannot be told.
    pub run: Box<dyn FnMut() -> f64>,
    /// Asks Mitsuba for the seconds that the same takes there.
    pub request: Option<Value>,
}

/// How seconds are told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unit {
    /// So many millions in these seconds, of something.
    MillionsPerSecond(f64, &'static str),
    Seconds,
    Milliseconds,
}

/// Where it runs.
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

    /// What is larger where things are faster: a rate, or one over a time.
    pub fn speed(self, seconds: f64) -> f64 {
        match self {
            Self::MillionsPerSecond(..) => self.value(seconds),
            Self::Seconds | Self::Milliseconds => 1.0 / self.value(seconds),
        }
    }
}
