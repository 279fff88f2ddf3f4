//! Dealing out tiles by the measured speed of the devices.

use crate::Result;
use crate::fleet::command::{Command, lead};
use crate::fleet::{Fleet, failure};
use crate::renderer::Counts;
use crate::renderer::phases::{Batch, longest_batch};

/// Samples per pixel with which a device's speed is measured.
const TRIAL_SAMPLES: u32 = 4;
/// Largest weight of a device.
const MOST_WEIGHT: u32 = 32;
/// How much longer than in proportion to the speeds a step may last, so that weights stay small.
const WANTED_LOSS: f64 = 1.03;

impl Fleet {
    /// Traces a few samples with every device of all ranks, and deals out the tiles by the speeds that this has shown. A device that would only
    /// slow the others down gets no tile. The render then begins without samples. Returns the weights of the devices.
    ///
    /// # Errors
    /// Where samples were taken already, or a device is lost.
    pub fn deal_by_speed(&mut self) -> Result<Vec<u32>> {
        self.check_unsampled()?;
        let team = self.team.clone();
        lead(team.as_deref(), || Command::DealBySpeed, || self.measure_and_deal())
    }

    /// Does this rank's part of dealing by speed.
    pub(super) fn measure_and_deal(&mut self) -> Result<Vec<u32>> {
        let samples = TRIAL_SAMPLES.min(longest_batch(self.first.settings(), 0));
        let trial = Batch { first: 0, samples, first_of_sets: 0 };
        // Devices reach their speed in the first trial.
        self.trace(trial, &mut Counts::default(), &|| false)?;
        let own = self.seconds_of_devices(trial);
        let seconds = match self.team.clone() {
            None => own?,
            Some(team) => {
                let all = |reports: Vec<Vec<u8>>| {
                    let seconds = reports.iter().map(|report| failure::decode::<Vec<f64>>(report));
                    Ok(failure::encode(&seconds.collect::<Result<Vec<_>>>()?.concat()))
                };
                failure::decode(&team.meet(own.map(|own| failure::encode(&own)), &|| false, all)?)?
            }
        };
        let weights = weights(&seconds);
        self.deal(&weights)?;
        self.start_over(self.first.settings().samples_per_dispatch, None)?;
        Ok(weights)
    }
}

/// Weights of devices that take these seconds for equal work: the smallest numbers with which a step is nearly as short as it can be, or
/// the best numbers up to [`MOST_WEIGHT`]. Equal weights where a time says nothing.
fn weights(seconds: &[f64]) -> Vec<u32> {
    if !seconds.iter().all(|&seconds| seconds > 0.0 && seconds.is_finite()) {
        return vec![1; seconds.len()];
    }
    let least = seconds.iter().copied().fold(f64::INFINITY, f64::min);
    let all_speeds: f64 = seconds.iter().map(|seconds| 1.0 / seconds).sum();
    let of_largest = |largest: u32| -> Vec<u32> {
        seconds.iter().map(|seconds| (f64::from(largest) * least / seconds).round() as u32).collect()
    };
    // How much longer a step lasts than if every device had work in proportion to its speed.
    let loss = |weights: &[u32]| {
        let whole = f64::from(weights.iter().sum::<u32>());
        let longest =
            weights.iter().zip(seconds).map(|(&weight, seconds)| f64::from(weight) * seconds).fold(0.0, f64::max);
        longest / whole * all_speeds
    };
    let candidates: Vec<_> = (1..=MOST_WEIGHT).map(of_largest).collect();
    let good = candidates.iter().find(|weights| loss(weights) <= WANTED_LOSS);
    let best = || candidates.iter().min_by(|a, b| loss(a).total_cmp(&loss(b)));
    good.or_else(best).cloned().unwrap_or_else(|| vec![1; seconds.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_follow_the_speeds() {
        assert_eq!(weights(&[2.0]), [1]);
        assert_eq!(weights(&[1.0, 1.02, 0.99]), [1, 1, 1]);
        assert_eq!(weights(&[1.0, 3.0]), [3, 1]);
        assert_eq!(weights(&[5.0, 2.0, 5.0]), [2, 5, 2]);
    }

    #[test]
    fn a_device_that_would_slow_the_others_down_gets_nothing() {
        assert_eq!(weights(&[1.0, 200.0]), [1, 0]);
        assert_eq!(weights(&[1.0, 1.0, 500.0]), [1, 1, 0]);
        // One of 30 times the speed leaves the slower device a share.
        let [fast, slow] = weights(&[1.0, 30.0])[..] else { panic!("two weights") };
        assert!(fast > 20 * slow, "{fast} : {slow}");
    }

    #[test]
    fn times_that_say_nothing_give_equal_weights() {
        assert_eq!(weights(&[0.0, 1.0]), [1, 1]);
        assert_eq!(weights(&[f64::NAN, 1.0, 1.0]), [1, 1, 1]);
    }
}
