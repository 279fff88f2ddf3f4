//! Sample weights: early samples of a guide are noisier than later ones, so they get smaller weights. A weight depends
//! on the sample's index alone and is fixed before a render begins, so the picture stays unbiased.

use crate::settings::{SampleWeights, Settings};

/// Samples per pixel in the first block. Every later block is as long as all blocks before it together.
const FIRST_BLOCK: u32 = 8;
/// Weights of the first blocks. All later samples have weight 1.
const WEIGHTS: [f32; 2] = [0.5, 0.75];

/// Sums over the weights of a pixel's first samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightSums {
    /// Sum of the weights.
    pub weight: f64,
    /// Sum of the squared weights.
    pub squares: f64,
    /// Weight of the first sample.
    pub first: f64,
}

impl Settings {
    /// Whether early samples have smaller weights.
    fn weighs_samples(&self) -> bool {
        self.sample_weights() == SampleWeights::Growing
    }

    /// Weight of a pixel's sample that follows `samples_before` others.
    pub fn weight_of_sample(&self, samples_before: u32) -> f32 {
        let weight = WEIGHTS.get(block_of(samples_before) as usize).copied().unwrap_or(1.0);
        if self.weighs_samples() { weight } else { 1.0 }
    }

    /// Number of samples, beginning after `samples_before`, that have one weight.
    pub fn samples_of_same_weight(&self, samples_before: u32) -> u32 {
        let block = block_of(samples_before);
        let ends = self.weighs_samples() && (block as usize) < WEIGHTS.len();
        if ends { (FIRST_BLOCK << block) - samples_before } else { u32::MAX }
    }

    /// Weight sums of a pixel's first `samples` samples.
    pub fn weight_sums(&self, samples: u32) -> WeightSums {
        let mut sums = WeightSums { weight: 0.0, squares: 0.0, first: f64::from(self.weight_of_sample(0)) };
        let mut done = 0;
        while done < samples {
            let count = self.samples_of_same_weight(done).min(samples - done);
            let weight = f64::from(self.weight_of_sample(done));
            sums.weight += weight * f64::from(count);
            sums.squares += weight * weight * f64::from(count);
            done += count;
        }
        sums
    }
}

impl WeightSums {
    /// Number of equally weighted samples whose mean would have the same variance.
    pub fn effective_samples(&self) -> f64 {
        if self.squares > 0.0 { self.weight * self.weight / self.squares } else { 0.0 }
    }

    /// Variance of the mean divided by the film's sum of squared deviations; 0 for fewer than two samples.
    pub fn variance_scale(&self) -> f64 {
        let spread = self.squares - self.first * self.first;
        if spread > 0.0 { self.squares / (spread * self.weight * self.weight) } else { 0.0 }
    }
}

/// Index of the block that holds the sample after `samples_before` others.
fn block_of(samples_before: u32) -> u32 {
    (samples_before / FIRST_BLOCK).checked_ilog2().map_or(0, |exponent| exponent + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};
    use crate::settings::Sampler;

    fn settings(sample_weights: SampleWeights) -> Settings {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        Settings {
            sample_weights: Some(sample_weights),
            ..Settings::for_film(&film, &IntegratorDescription::default())
        }
    }

    #[test]
    fn blocks_double() {
        let growing = settings(SampleWeights::Growing);
        for (begin, end, weight) in [(0, 8, 0.5), (8, 16, 0.75)] {
            for done in begin..end {
                let block = (growing.weight_of_sample(done), growing.samples_of_same_weight(done));
                assert_eq!(block, (weight, end - done), "{done}");
            }
        }
        assert_eq!((growing.weight_of_sample(16), growing.samples_of_same_weight(16)), (1.0, u32::MAX));
        assert_eq!((growing.weight_of_sample(u32::MAX), growing.samples_of_same_weight(u32::MAX)), (1.0, u32::MAX));
    }

    #[test]
    fn product_has_the_schedule_unless_it_does_not_go_with_the_rest() {
        let product = Settings { sample_weights: None, ..settings(SampleWeights::Even) };
        assert_eq!(product.sample_weights(), SampleWeights::Growing);
        let part = Settings { sample_offset: Some(0), ..product.clone() };
        let by_noise = Settings { noise: Some(0.1), ..product.clone() };
        let other = Settings { sampler: Sampler::RejectionMix, ..product };
        for settings in [part, by_noise, other] {
            assert_eq!(settings.sample_weights(), SampleWeights::Even);
            settings.validate().expect("what goes together");
        }
    }

    #[test]
    fn without_a_schedule_all_weigh_the_same() {
        let sums = settings(SampleWeights::Even).weight_sums(100);
        assert_eq!((sums.weight, sums.squares, sums.effective_samples()), (100.0, 100.0, 100.0));
        assert!((sums.variance_scale() * 9900.0 - 1.0).abs() < 1.0e-12);
    }

    #[test]
    fn sums_are_those_of_the_samples() {
        let growing = settings(SampleWeights::Growing);
        for samples in [0, 1, 7, 8, 9, 31, 64, 65, 1000] {
            let weights = || (0..samples).map(|done| f64::from(growing.weight_of_sample(done)));
            let sums = growing.weight_sums(samples);
            let expected = (weights().sum::<f64>(), weights().map(|weight| weight * weight).sum::<f64>());
            assert_eq!((sums.weight, sums.squares), expected, "{samples}");
        }
        assert_eq!(growing.weight_sums(1).variance_scale(), 0.0);
        // Little is lost where all samples have the same variance.
        assert!(growing.weight_sums(64).effective_samples() > 61.0);
    }
}
