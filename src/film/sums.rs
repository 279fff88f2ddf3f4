//! Integer sums over a pixel's samples. Integer addition does not depend on order, so a frame can be shared out between
//! renders. Every step adds one set of sums.

use bytemuck::{Pod, Zeroable};

use crate::film::features::{FEATURE_CHANNELS, FEATURES, MeanOver, channels_over};
use crate::generated::layout::{FilmFeatures, FilmRadiance};

/// Units per 1 of sums of radiance, and of features whose means run over hits: 2^64, for sums up to 9e18.
const UNITS: f64 = 18_446_744_073_709_551_616.0;
/// Units per 1 in the upper words of squares: 2^32. The lower words hold units of 2^-96.
const SQUARE_UNITS: f64 = 4_294_967_296.0;
/// Units per 1 of sums of features whose means run over all samples: 2^32, for sums up to 2e9.
const FEATURE_UNITS: f64 = 4_294_967_296.0;
/// Variance, as a share of the mean square, below which it is only the rounding of samples to 24 bits.
const ROUNDING_SHARE: f64 = 1.0 / (1u64 << 48) as f64;

/// Channels of features whose means run over all samples.
const OF_SAMPLES: usize = channels_over(MeanOver::Samples);
/// Channels of features whose means run over hits.
const OF_HITS: usize = channels_over(MeanOver::Hits);

/// Sums over the samples of one pixel.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct PixelSums {
    radiance: [i128; 3],
    squares_high: [i128; 3],
    of_hits: [i128; OF_HITS],
    squares_low: [u64; 3],
    of_samples: [i64; OF_SAMPLES],
    sample_count: u32,
    hit_count: u32,
    /// Words that make the size a multiple of the alignment.
    padding: [u32; OF_SAMPLES % 2 * 2],
}

/// Means over the samples of one pixel. The fields are those of [`Picture`](crate::film::Picture).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PixelMeans {
    /// Mean radiance.
    pub radiance: [f32; 3],
    /// Variance of the mean radiance.
    pub variance: [f32; 3],
    /// Means of the features: the channels of [`FEATURES`], one after another.
    pub features: [f32; FEATURE_CHANNELS],
    /// Number of samples.
    pub sample_count: u32,
    /// Number of samples that hit a surface.
    pub hit_count: u32,
}

impl PixelSums {
    /// Size in 32-bit words.
    pub const WORDS: usize = size_of::<Self>() / 4;

    /// Sums of the samples that the film's moments describe. The sums are rounded, but equal moments give equal sums.
    pub fn of_moments(radiance: &FilmRadiance, features: &FilmFeatures) -> Self {
        let (samples, hits) = (f64::from(radiance.sample_count), f64::from(radiance.hit_count));
        let mean = radiance.mean.map(f64::from);
        let squares: [f64; 3] = std::array::from_fn(|c| {
            (f64::from(radiance.squared_deviation[c]) + samples * mean[c] * mean[c]) * SQUARE_UNITS
        });
        let mut sums = Self {
            radiance: mean.map(|mean| (samples * mean * UNITS) as i128),
            squares_high: squares.map(|square| square.floor() as i128),
            squares_low: squares.map(|square| ((square - square.floor()) * UNITS) as u64),
            sample_count: radiance.sample_count,
            hit_count: radiance.hit_count,
            ..Self::default()
        };
        let means_over = |mean| {
            let wanted = FEATURES.iter().filter(move |feature| feature.mean == mean);
            wanted.flat_map(|feature| (feature.of_film)(features)).map(|&mean| f64::from(mean))
        };
        for (sum, mean) in sums.of_samples.iter_mut().zip(means_over(MeanOver::Samples)) {
            *sum = (samples * mean * FEATURE_UNITS) as i64;
        }
        for (sum, mean) in sums.of_hits.iter_mut().zip(means_over(MeanOver::Hits)) {
            *sum = (hits * mean * UNITS) as i128;
        }
        sums
    }

    /// Adds the samples of `other`.
    pub fn add(&mut self, other: &Self) {
        for c in 0..3 {
            self.radiance[c] = self.radiance[c].wrapping_add(other.radiance[c]);
            let (low, carry) = self.squares_low[c].overflowing_add(other.squares_low[c]);
            self.squares_low[c] = low;
            self.squares_high[c] = self.squares_high[c].wrapping_add(other.squares_high[c]).wrapping_add(carry.into());
        }
        for (sum, other) in self.of_samples.iter_mut().zip(other.of_samples) {
            *sum = sum.wrapping_add(other);
        }
        for (sum, other) in self.of_hits.iter_mut().zip(other.of_hits) {
            *sum = sum.wrapping_add(other);
        }
        self.sample_count = self.sample_count.saturating_add(other.sample_count);
        self.hit_count = self.hit_count.saturating_add(other.hit_count);
    }

    /// Means, and the variance of the mean radiance.
    pub fn means(&self) -> PixelMeans {
        let (samples, hits) = (f64::from(self.sample_count), f64::from(self.hit_count));
        let per_sample = 1.0 / samples.max(1.0);
        let mut means = PixelMeans { sample_count: self.sample_count, hit_count: self.hit_count, ..Default::default() };
        for c in 0..3 {
            let sum = self.radiance[c] as f64 / UNITS;
            let squares = (self.squares_high[c] as f64 + self.squares_low[c] as f64 / UNITS) / SQUARE_UNITS;
            let deviation = squares - sum * sum * per_sample;
            let is_rounding = deviation <= squares * ROUNDING_SHARE || self.sample_count < 2;
            let variance = if is_rounding { 0.0 } else { deviation / (samples * (samples - 1.0)) };
            means.radiance[c] = (sum * per_sample) as f32;
            means.variance[c] = variance as f32;
        }
        let mut of_samples = self.of_samples.iter().map(|&sum| (sum as f64 / FEATURE_UNITS * per_sample) as f32);
        let mut of_hits = self.of_hits.iter().map(|&sum| (sum as f64 / UNITS / hits) as f32);
        let channels = FEATURES.iter().flat_map(|feature| feature.channels.iter().map(|_| feature.mean));
        for (mean, over) in means.features.iter_mut().zip(channels) {
            let known = match over {
                MeanOver::Samples => of_samples.next(),
                MeanOver::Hits => of_hits.next().filter(|_| self.hit_count > 0),
            };
            *mean = known.unwrap_or(over.of_nothing());
        }
        means
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Picture;
    use proptest::prelude::*;

    fn moments(mean: f32, squared_deviation: f32, sample_count: u32) -> PixelSums {
        let (mean, squared_deviation) = ([mean, mean * 3.0, mean * 1e-6], [squared_deviation; 3]);
        let radiance = FilmRadiance { mean, sample_count, squared_deviation, hit_count: sample_count / 2 };
        let features =
            FilmFeatures { albedo: [0.3; 3], depth: mean[1], normal: [-0.7, 0.1, 0.0], ..FilmFeatures::zeroed() };
        PixelSums::of_moments(&radiance, &features)
    }

    fn picture_of(sums: &PixelSums) -> Picture {
        let mut picture = Picture::empty(1, 1, [0, 0], [1, 1]);
        picture.set_pixel(0, &sums.means());
        picture
    }

    #[test]
    fn one_step_comes_back() {
        let picture = picture_of(&moments(0.25, 1.5, 8));
        assert_eq!(picture.radiance[0], [0.25, 0.75, 0.25e-6]);
        assert_eq!(picture.variance[0].map(|v| (v * 56.0 * 1e5).round()), [1.5e5; 3]);
        assert_eq!((picture.sample_count[0], picture.hit_count[0], picture.depth()[0]), (8, 4, 0.75));
        assert!((picture.albedo()[0][0] - 0.3).abs() < 1e-6 && (picture.normal()[0][0] + 0.7).abs() < 1e-6);
    }

    #[test]
    fn samples_that_are_all_the_same_have_no_variance() {
        let mut sums = PixelSums::default();
        (0..1000).for_each(|_| sums.add(&moments(0.1, 0.0, 8)));
        let picture = picture_of(&sums);
        assert_eq!((picture.radiance[0][0], picture.variance[0]), (0.1, [0.0; 3]));
        assert_eq!(picture_of(&PixelSums::default()).depth()[0], f32::INFINITY);
    }

    /// Means and variance of the whole are checked against the textbook formula in twice the precision.
    #[test]
    fn steps_add_up_to_the_whole() {
        let steps = [(0.5, 2.0, 8), (3.0, 0.25, 8), (1e4, 1e6, 4)];
        let mut sums = PixelSums::default();
        steps.iter().for_each(|&(mean, squared, count)| sums.add(&moments(mean, squared, count)));
        let count = 20.0;
        let mean = (0.5 * 8.0 + 3.0 * 8.0 + 1e4 * 4.0) / count;
        let squared: f64 =
            steps.iter().map(|&(m, s, n)| f64::from(s) + f64::from(n) * (f64::from(m) - mean).powi(2)).sum();
        let picture = picture_of(&sums);
        assert_eq!(picture.radiance[0][0], mean as f32);
        let expected = (squared / (count * (count - 1.0))) as f32;
        assert!((picture.variance[0][0] / expected - 1.0).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn neither_order_nor_grouping_changes_a_bit(
            steps in prop::collection::vec((-20.0f32..20.0, 0.0f32..1e3, 1u32..65), 2..12), cut in 1usize..11,
        ) {
            let steps: Vec<_> = steps.into_iter().map(|(e, squared, n)| moments(e.exp2() * 1e3, squared, n)).collect();
            let sum = |steps: &[PixelSums]| {
                let mut sums = PixelSums::default();
                steps.iter().for_each(|step| sums.add(step));
                sums
            };
            let (first, second) = steps.split_at(cut.min(steps.len() - 1));
            let mut parts = sum(second);
            parts.add(&sum(first));
            prop_assert_eq!(parts, sum(&steps));
        }
    }
}
