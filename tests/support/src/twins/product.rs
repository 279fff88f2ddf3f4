//! Twin of the descent in `glsl/include/guide/samplers/product.glsl`, and of the weights that it follows.

use std::f64::consts::PI;

/// Largest number that few bits can store.
pub const LARGEST: f64 = 1.875;
/// Smallest number that 7 bits can store.
pub const LEAST_7: f64 = 1.0 / 32_768.0;
/// Smallest number that 8 bits can store.
pub const LEAST_8: f64 = 1.0 / 2_147_483_648.0;

/// Share of the cosine unless `--epsilon` sets it: `bsdf_share` in GLSL.
pub const COSINE_SHARE: f64 = 0.25;

/// Functions that a descent multiplies, with a value for every bin of the map, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Product<'a> {
    /// Radiance of every bin.
    pub radiance: &'a [f32],
    /// Integral of the clamped cosine over every bin, sr.
    pub integrals: &'a [f64],
}

/// Weights of a node's sixteen parts, row by row; 0 for a part that the node does not have.
type Weights = [f64; 16];

/// Nearest number to `x` with three bits of mantissa, at least `least`.
pub fn small_float(x: f64, least: f64) -> f64 {
    if x <= least {
        return least;
    }
    let power = x.log2().floor().exp2();
    (power * (8.0 * x / power).round() / 8.0).max(least)
}

/// Weights as they are stored: relative to the largest, in few bits.
fn stored(weights: &Weights, least: f64) -> Weights {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let scale = if largest > 1.0e-36 && largest < 1.0e37 { LARGEST / largest } else { 0.0 };
    weights.map(|weight| small_float(weight * scale, least))
}

impl Product<'_> {
    fn side(&self) -> usize {
        self.radiance.len().isqrt()
    }

    /// Sum of a function of bins over a square of bins.
    fn sum(&self, corner: [usize; 2], side: usize, value: impl Fn(usize) -> f64) -> f64 {
        let bins = (0..side * side).map(|i| (corner[1] + i / side) * self.side() + corner[0] + i % side);
        bins.map(value).sum()
    }

    /// Sums of a function of bins over `parts * parts` squares, each `side` bins wide.
    fn sums(&self, corner: [usize; 2], parts: usize, side: usize, value: impl Fn(usize) -> f64 + Copy) -> Weights {
        std::array::from_fn(|i| {
            let (x, y) = (i % 4, i / 4);
            let inside = x < parts && y < parts;
            if inside { self.sum([corner[0] + x * side, corner[1] + y * side], side, value) } else { 0.0 }
        })
    }

    fn radiance(&self, bin: usize) -> f64 {
        f64::from(self.radiance[bin])
    }

    /// Weights of the parts of a node below the first level.
    fn node(&self, corner: [usize; 2], parts: usize, side: usize) -> Weights {
        let radiance = stored(&self.sums(corner, parts, side, |bin| self.radiance(bin)), LEAST_8);
        let cosine = stored(&self.sums(corner, parts, side, |bin| self.integrals[bin]), LEAST_8);
        let has_part = |i: usize| i % 4 < parts && i / 4 < parts;
        std::array::from_fn(|i| if has_part(i) { radiance[i] * cosine[i] } else { 0.0 })
    }

    /// Weights of the map's sixteen blocks, as they are stored.
    pub fn block_weights(&self) -> [f64; 16] {
        let products = self.sums([0, 0], 4, self.side() / 4, |bin| self.radiance(bin) * self.integrals[bin]);
        stored(&products, LEAST_7)
    }

    /// Probability of a bin.
    pub fn probability(&self, bin: usize) -> f64 {
        let at = [bin % self.side(), bin / self.side()];
        let block_side = self.side() / 4;
        let mut probability = share(&self.block_weights(), at.map(|x| x / block_side));
        if self.side() > 16 {
            let corner = at.map(|x| x / block_side * block_side);
            let weights = self.node(corner, self.side() / 16, 4);
            probability *= share(&weights, at.map(|x| x % block_side / 4));
        }
        probability * share(&self.node(at.map(|x| x / 4 * 4), 4, 1), at.map(|x| x % 4))
    }

    /// Density in a bin, per steradian.
    pub fn density(&self, bin: usize) -> f64 {
        self.probability(bin) * self.radiance.len() as f64 / (4.0 * PI)
    }
}

fn share(weights: &Weights, part: [usize; 2]) -> f64 {
    weights[4 * part[1] + part[0]] / weights.iter().sum::<f64>()
}
