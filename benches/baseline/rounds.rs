//! Rounds of measurements. In each round every quantity is measured once.

use std::collections::HashMap;

use serde_json::Value;
use support::bench::median;

use crate::calibration::Calibration;
use crate::mitsuba::Mitsuba;
use crate::quantity::Quantity;

/// Results of all rounds for a quantity.
pub struct Measured {
    pub name: String,
    pub unit: String,
    /// Median of the values.
    pub value: f64,
    pub least: f64,
    pub most: f64,
    /// Median of the speed relative to that of the calibrating work right before it.
    pub calibrated_speed: f64,
    /// Median speed of the calibrating work, in 10^9 operations per second.
    pub calibration: f64,
    /// Median of Mitsuba's values; NaN if Mitsuba has not measured this quantity.
    pub mitsuba: f64,
    /// Median of the speed relative to Mitsuba's speed in the same round.
    pub relative_to_mitsuba: f64,
}

/// Measurement of a quantity in one round.
struct Turn {
    seconds: f64,
    calibration: f64,
    mitsuba_seconds: f64,
}

/// Answers of Mitsuba in one round. Several quantities may make the same request.
struct Answers<'a> {
    mitsuba: &'a mut Mitsuba,
    seconds: HashMap<String, f64>,
}

impl Answers<'_> {
    fn to(&mut self, request: &Value) -> f64 {
        *self.seconds.entry(request.to_string()).or_insert_with(|| self.mitsuba.seconds(request))
    }
}

/// Measures all quantities. A first round, which compiles and warms up, does not count.
pub fn measure(
    quantities: &mut [Quantity],
    calibration: &Calibration,
    mitsuba: &mut Mitsuba,
    rounds: usize,
) -> Vec<Measured> {
    let mut turns: Vec<Vec<Turn>> = quantities.iter().map(|_| Vec::new()).collect();
    for round in 0..=rounds {
        let begin = std::time::Instant::now();
        let mut mitsuba = Answers { mitsuba, seconds: HashMap::new() };
        for (turns, quantity) in turns.iter_mut().zip(quantities.iter_mut()) {
            let turn = Turn {
                calibration: calibration.rate(quantity.place),
                seconds: (quantity.run)(),
                mitsuba_seconds: quantity.request.as_ref().map_or(f64::NAN, |request| mitsuba.to(request)),
            };
            if round > 0 {
                turns.push(turn);
            }
        }
        eprintln!("round {round} of {rounds}: {:.1} s", begin.elapsed().as_secs_f64());
    }
    quantities.iter().zip(turns).map(|(quantity, turns)| summary(quantity, &turns)).collect()
}

fn summary(quantity: &Quantity, turns: &[Turn]) -> Measured {
    let unit = quantity.unit;
    let of = |number: &dyn Fn(&Turn) -> f64| turns.iter().map(number).collect::<Vec<f64>>();
    let values = of(&|turn| unit.value(turn.seconds));
    Measured {
        name: quantity.name.clone(),
        unit: unit.name(),
        least: values.iter().copied().fold(f64::INFINITY, f64::min),
        most: values.iter().copied().fold(0.0, f64::max),
        value: median(values),
        calibrated_speed: median(of(&|turn| unit.speed(turn.seconds) / turn.calibration)),
        calibration: median(of(&|turn| turn.calibration)),
        mitsuba: unit.value(median(of(&|turn| turn.mitsuba_seconds))),
        relative_to_mitsuba: median(of(&|turn| turn.mitsuba_seconds / turn.seconds)),
    }
}
