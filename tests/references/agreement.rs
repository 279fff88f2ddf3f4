//! Agreement of two noisy pictures: a z-test on blocks of pixels, and one on the mean luminance.

use std::fmt;

use lodestar::image::Image;
use statrs::distribution::{ContinuousCDF, Normal};

/// Probability that the blocks of one picture reject a correct one, before the accepted share below forgives some.
const SIGNIFICANCE: f64 = 0.01;
/// Minimum share of accepted blocks. The test assumes normal noise, and heavy tails reject a few blocks.
const LEAST_ACCEPTED: f64 = 0.9975;
/// Maximum deviation of the mean luminance, where three standard errors are less.
const LUMINANCE_TOLERANCE: f64 = 0.01;
/// Relative error that nearly all blocks must stay below. Blocks grow until they do: with a larger error, noise is too
/// far from normal for the test.
const KNOWN_ERROR: f64 = 0.05;
const KNOWN_SHARE: f64 = 0.97;
const SIDES: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];

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

    /// Means over blocks of `side` x `side` pixels. Errors of different pixels are independent.
    fn blocks(&self, side: usize) -> Self {
        let columns = self.width.div_ceil(side);
        let count = columns * (self.mean.len() / self.width).div_ceil(side);
        let mut blocks = Self { width: columns, mean: vec![[0.0; 3]; count], variance: vec![[0.0; 3]; count] };
        let mut pixels = vec![0.0; count];
        for (at, (mean, variance)) in self.mean.iter().zip(&self.variance).enumerate() {
            let block = at / self.width / side * columns + at % self.width / side;
            pixels[block] += 1.0;
            for channel in 0..3 {
                blocks.mean[block][channel] += mean[channel];
                blocks.variance[block][channel] += variance[channel];
            }
        }
        for (block, count) in pixels.into_iter().enumerate() {
            blocks.mean[block] = blocks.mean[block].map(|sum| sum / count);
            blocks.variance[block] = blocks.variance[block].map(|sum| sum / count / count);
        }
        blocks
    }

    /// Mean luminance of the picture, and its standard error. Channels of a pixel count as fully dependent.
    pub fn luminance(&self) -> (f64, f64) {
        const WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];
        let weigh = |color: [f64; 3]| (0..3).map(|c| WEIGHTS[c] * color[c]).sum::<f64>();
        let count = self.mean.len() as f64;
        let mean = self.mean.iter().map(|&color| weigh(color)).sum::<f64>() / count;
        let variance = self.variance.iter().map(|color| weigh(color.map(f64::sqrt)).powi(2)).sum::<f64>();
        (mean, variance.sqrt() / count)
    }
}

/// Result of the tests.
pub struct Agreement {
    /// Side of the blocks in pixels.
    pub side: usize,
    /// Number of blocks times channels.
    pub count: usize,
    /// Share of accepted blocks.
    pub accepted: f64,
    /// Largest deviation, in standard deviations.
    pub largest: f64,
    /// Mean luminance, relative to the reference's.
    pub ratio: f64,
    /// Standard error of the relative mean luminance.
    pub error: f64,
}

impl Agreement {
    pub fn new(picture: &Estimate, reference: &Estimate) -> Self {
        assert_eq!((picture.width, picture.mean.len()), (reference.width, reference.mean.len()));
        let side = SIDES.into_iter().find(|&side| is_known(picture, reference, side)).unwrap_or(SIDES[6]);
        let z = deviations(&picture.blocks(side), &reference.blocks(side));
        let limit = largest_expected(z.len());
        let accepted = z.iter().filter(|z| z.abs() <= limit).count() as f64 / z.len() as f64;
        let (mean, error) = picture.luminance();
        let (reference_mean, reference_error) = reference.luminance();
        Self {
            side,
            count: z.len(),
            accepted,
            largest: z.iter().fold(0.0, |most, z| z.abs().max(most)),
            ratio: mean / reference_mean,
            error: error.hypot(reference_error) / reference_mean,
        }
    }

    pub fn holds(&self) -> bool {
        self.accepted >= LEAST_ACCEPTED && (self.ratio - 1.0).abs() <= LUMINANCE_TOLERANCE.max(3.0 * self.error)
    }
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { side, count, accepted, largest, ratio, error } = self;
        write!(
            f,
            "{:.2} % of {count} accepted (blocks of {side} px, largest |z| {largest:.1}), luminance {:+.2} % +- {:.2} %",
            100.0 * accepted,
            100.0 * (ratio - 1.0),
            100.0 * error
        )
    }
}

/// Deviations in combined standard deviations, per block and channel. Values without noise still differ by rounding.
fn deviations(a: &Estimate, b: &Estimate) -> Vec<f64> {
    let z = |at: usize| {
        [0, 1, 2].map(|c| {
            let rounding = (1.0e-4 * b.mean[at][c]).powi(2) + 1.0e-14;
            (a.mean[at][c] - b.mean[at][c]) / (a.variance[at][c] + b.variance[at][c] + rounding).sqrt()
        })
    };
    (0..a.mean.len()).flat_map(z).collect()
}

/// Whether nearly all blocks have a small enough error. The decision uses the noise only, never the deviation.
fn is_known(a: &Estimate, b: &Estimate, side: usize) -> bool {
    let (a, b) = (a.blocks(side), b.blocks(side));
    let known = |at: usize| {
        let (mean, variance) = (0..3).fold((0.0, 0.0), |(mean, variance), c| {
            (mean + b.mean[at][c] + a.mean[at][c], variance + (a.variance[at][c] + b.variance[at][c]).sqrt())
        });
        variance <= KNOWN_ERROR * 0.5 * mean
    };
    (0..a.mean.len()).filter(|&at| known(at)).count() as f64 >= KNOWN_SHARE * a.mean.len() as f64
}

/// Deviation that the largest of `count` normal ones exceeds with probability [`SIGNIFICANCE`] (Sidak 1967).
fn largest_expected(count: usize) -> f64 {
    let each = -((-SIGNIFICANCE).ln_1p() / count as f64).exp_m1();
    Normal::standard().inverse_cdf(1.0 - 0.5 * each)
}

/// The tests find planted faults and accept correct pictures: made-up pictures of `64 x 64` pixels with 2 % noise.
pub fn check_itself() {
    let noisy = |seed: u64, change: &dyn Fn(usize) -> f64| {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let pixels = (0..4096).map(|at| [(change(at) * (1.0 + 0.02 * normal())) as f32; 3]).collect();
        let image = |pixels| Image { width: 64, height: 64, pixels };
        Estimate::new(&image(pixels), &image(vec![[4.0e-4; 3]; 4096]))
    };
    let reference = noisy(1, &|_| 1.0);
    let holds = |change: &dyn Fn(usize) -> f64| Agreement::new(&noisy(2, change), &reference).holds();
    assert!(holds(&|_| 1.0), "two pictures of the same");
    assert!(!holds(&|_| 1.02), "2 % too bright");
    assert!(!holds(&|at| if at < 20 { 1.5 } else { 1.0 }), "a half percent of the pixels wrong");
}
