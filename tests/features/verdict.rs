//! Pictures in blocks, and what a comparison of two says.

use std::fmt;

use lodestar::film::Picture;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use support::significance::{sidak, two_sided};

/// Side of a block in pixels, and number of blocks.
pub const SIDE: usize = 6;
pub const BLOCKS: usize = 12;

/// Largest relative error of a block that is compared. Where few paths find light, noise is far from normally distributed, and
/// its variance is unknown.
const KNOWN_ERROR: f64 = 0.05;
/// Values without noise still differ by rounding: the largest relative difference that counts as none.
const ROUNDING: f64 = 2.0e-5;

/// Mean and variance of the mean, for each block and color channel.
#[derive(Debug, Clone)]
pub struct Blocks {
    pub mean: [[f64; 3]; BLOCKS],
    pub variance: [[f64; 3]; BLOCKS],
}

impl Blocks {
    /// Blocks of one color, without noise.
    pub fn uniform(color: [f64; 3]) -> Self {
        Self { mean: [color; BLOCKS], variance: [[0.0; 3]; BLOCKS] }
    }

    pub fn of(picture: &Picture) -> Self {
        let columns = picture.width as usize / SIDE;
        assert_eq!(columns * (picture.height as usize / SIDE), BLOCKS, "the size of the film");
        let mut blocks = Self::uniform([0.0; 3]);
        let pixels = (SIDE * SIDE) as f64;
        for at in 0..picture.radiance.len() {
            let block = at / picture.width as usize / SIDE * columns + at % picture.width as usize / SIDE;
            for channel in 0..3 {
                blocks.mean[block][channel] += f64::from(picture.radiance[at][channel]) / pixels;
                blocks.variance[block][channel] += f64::from(picture.variance[at][channel]) / pixels.powi(2);
            }
        }
        blocks
    }

    /// Mean of each block over its channels, and its standard error as if all channels had the same error.
    fn gray(&self) -> Vec<(f64, f64)> {
        let third = |color: &[f64; 3]| color.iter().sum::<f64>() / 3.0;
        let error = |variance: &[f64; 3]| third(&variance.map(f64::sqrt));
        self.mean.iter().zip(&self.variance).map(|(mean, variance)| (third(mean), error(variance))).collect()
    }

    /// Mean of the picture, and its standard error.
    pub fn whole(&self) -> (f64, f64) {
        let blocks = self.gray();
        let count = blocks.len() as f64;
        let mean = blocks.iter().map(|block| block.0).sum::<f64>() / count;
        (mean, blocks.iter().map(|block| block.1.powi(2)).sum::<f64>().sqrt() / count)
    }
}

/// Comparison of a picture with its reference.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// Mean, relative to the reference's.
    pub ratio: f64,
    /// Deviation of the mean in combined standard errors.
    pub z: f64,
    /// Largest deviation of a block and channel, in combined standard errors; and the block's ratio.
    pub worst: (f64, f64),
    /// Number of blocks and channels whose error is small enough to compare them.
    pub known: usize,
    /// Probability that a right picture deviates as much: by its mean, by a block, or by all blocks together.
    pub p: f64,
}

impl Verdict {
    pub fn new(picture: &Blocks, reference: &Blocks) -> Self {
        let ((mean, own), (right, its)) = (picture.whole(), reference.whole());
        let z = (mean - right) / own.hypot(its).hypot(ROUNDING * right).max(1e-12);
        let (mut worst, mut known) = ((0.0, 1.0), 0);
        for at in 0..BLOCKS {
            for channel in 0..3 {
                let (a, b) = (picture.mean[at][channel], reference.mean[at][channel]);
                let error = (picture.variance[at][channel] + reference.variance[at][channel]).sqrt();
                if error > KNOWN_ERROR * 0.5 * (a + b).abs() {
                    continue;
                }
                known += 1;
                let z = (a - b) / error.hypot(ROUNDING * a.max(b)).max(1e-12);
                if z.abs() > f64::abs(worst.0) {
                    worst = (z, a / b);
                }
            }
        }
        let gray = picture.gray().into_iter().zip(reference.gray());
        let deviations: Vec<f64> = gray
            .filter(|((a, own), (b, its))| own.hypot(*its) <= KNOWN_ERROR * 0.5 * (a + b))
            .map(|((a, own), (b, its))| (a - b) / own.hypot(its).hypot(ROUNDING * b).max(1e-12))
            .collect();
        let together = match deviations.len() {
            0 => 1.0,
            count => ChiSquared::new(count as f64).expect("positive").sf(deviations.iter().map(|z| z * z).sum()),
        };
        let least = two_sided(z).min(sidak(two_sided(worst.0), known.max(1))).min(together);
        Self { ratio: mean / right, z, worst, known, p: sidak(least, 3) }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { ratio, z, worst, known, p } = self;
        write!(
            f,
            "ratio {ratio:.4}, z {z:.1}, worst of {known} block values {:.3} with z {:.1}, p {p:.1e}",
            worst.1, worst.0
        )
    }
}
