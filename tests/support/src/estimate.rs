//! Pictures with their variances, and the z-test of one against another.

use std::fmt;

use lodestar::film::Picture;
use lodestar::image::Image;

use crate::significance::{ALPHA, sidak, two_sided};

/// Side of a block that holds the whole picture.
pub const WHOLE: usize = usize::MAX;

/// Largest relative error of a value that a z-test uses. Where few paths find light, noise is far from normally
/// distributed and its variance is unknown: a pixel that no path has lit has variance 0. A relative error of 0.1 takes
/// a hundred such paths or more.
const MAX_RELATIVE_ERROR: f64 = 0.1;

/// Estimate of every pixel and channel, with the variance of its error.
pub struct Estimate {
    width: usize,
    mean: Vec<[f64; 3]>,
    variance: Vec<[f64; 3]>,
}

impl Estimate {
    pub fn new(mean: &Image, variance: &Image) -> Self {
        let doubles = |image: &Image| image.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
        Self { width: mean.width as usize, mean: doubles(mean), variance: doubles(variance) }
    }

    pub fn of(picture: &Picture) -> Self {
        Self::new(&picture.image(), &picture.variance_image())
    }

    /// Sum over pixels and channels.
    pub fn total_variance(&self) -> f64 {
        self.variance.iter().flatten().sum()
    }

    /// Means over blocks of `side` x `side` pixels. Errors of different pixels are independent.
    pub fn blocks(&self, side: usize) -> Self {
        let height = self.mean.len() / self.width;
        let columns = self.width.div_ceil(side);
        let block_count = columns * height.div_ceil(side);
        let mut blocks =
            Self { width: columns, mean: vec![[0.0; 3]; block_count], variance: vec![[0.0; 3]; block_count] };
        let mut pixels = vec![0.0; block_count];
        for at in 0..self.mean.len() {
            let block = at / self.width / side * columns + at % self.width / side;
            pixels[block] += 1.0;
            for channel in 0..3 {
                blocks.mean[block][channel] += self.mean[at][channel];
                blocks.variance[block][channel] += self.variance[at][channel];
            }
        }
        for (block, count) in pixels.into_iter().enumerate() {
            blocks.mean[block] = blocks.mean[block].map(|sum| sum / count);
            blocks.variance[block] = blocks.variance[block].map(|sum| sum / count / count);
        }
        blocks
    }

    /// Mean over all pixels and channels, and its standard error as if all channels had the same error.
    pub fn gray(&self) -> (f64, f64) {
        let whole = self.blocks(WHOLE);
        let mean = |of: [f64; 3]| of.iter().sum::<f64>() / 3.0;
        (mean(whole.mean[0]), mean(whole.variance[0].map(f64::sqrt)))
    }

    /// Deviation from `other` in combined standard deviations, for every pixel and channel with a small enough error.
    pub fn z(&self, other: &Self) -> Vec<f64> {
        assert_eq!((self.width, self.mean.len()), (other.width, other.mean.len()));
        let pixel = |at: usize| {
            [0, 1, 2].into_iter().filter_map(move |channel| {
                let (a, b) = (self.mean[at][channel], other.mean[at][channel]);
                // Values without noise still differ by rounding.
                let rounding = 1.0e-5 * a.abs().max(b.abs());
                let variance = self.variance[at][channel] + other.variance[at][channel] + rounding * rounding;
                let is_known = variance.sqrt() <= MAX_RELATIVE_ERROR * 0.5 * (a + b).abs();
                is_known.then(|| (a - b) / variance.sqrt())
            })
        };
        (0..self.mean.len()).flat_map(pixel).collect()
    }
}

/// Result of the z-tests of two pictures at all scales.
pub struct Comparison {
    /// P-value of the largest deviation, Sidak-corrected over the blocks and channels of all scales.
    pub p: f64,
    /// Largest deviation at each scale, in standard deviations, and the number of values at that scale.
    pub largest: Vec<(f64, usize)>,
    /// Deviation of the whole picture's mean, for the channel that deviates most.
    pub whole: f64,
}

impl Comparison {
    /// Compares the means of blocks of the given sides: 1 is a pixel, [`WHOLE`] the picture.
    pub fn new(a: &Estimate, b: &Estimate, sides: &[usize]) -> Self {
        let at_scale = |side: usize| a.blocks(side).z(&b.blocks(side));
        let largest = |z: &[f64]| z.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
        let scales: Vec<_> = sides.iter().map(|&side| at_scale(side)).collect();
        let smallest = scales.iter().map(|z| sidak(two_sided(largest(z)), z.len())).fold(1.0, f64::min);
        Self {
            p: sidak(smallest, scales.len()),
            largest: scales.iter().map(|z| (largest(z), z.len())).collect(),
            whole: largest(&at_scale(WHOLE)),
        }
    }

    pub fn agrees(&self) -> bool {
        self.p > ALPHA
    }
}

impl fmt::Debug for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "p = {:.2e}, whole |z| = {:.2}, largest |z| (of)", self.p, self.whole)?;
        self.largest.iter().try_for_each(|(z, count)| write!(f, " {z:.2} ({count})"))
    }
}
