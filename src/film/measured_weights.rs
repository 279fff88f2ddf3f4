//! What samples count for where that is measured: the noisier the steps that they belong to, the less. CPU only.
//!
//! Steps are put together to blocks, each of at least as many samples as all before it, and pixels to two halves, like the
//! squares of a chessboard. A block's samples are weighed by the inverse of their variance (Müller 2019, "Practical Path Guiding
//! in Production"), and these of either half's pixels by what is measured over the other half: so no sample's own luck decides
//! what it counts for. It still has a part in the guide, and thereby in the variance of later samples. So pictures are consistent,
//! not unbiased: the bias falls with the noise.

use bytemuck::{Pod, Zeroable};

use crate::generated::layout::FilmRadiance;

/// Fewest samples per pixel of a block.
pub const LEAST_BLOCK: u32 = 8;
/// Samples count for no more than this times what those of the mean variance count for.
const MOST_WEIGHT: f64 = 16.0;
/// A pixel's standard deviation is taken for no more than this times its half's mean radiance: a single path that is brighter
/// would decide alone. Müller's code bounds variances by 10^4 likewise.
const MOST_DEVIATION: f64 = 100.0;
/// Pixels along a side of a tile of the film.
const TILE_SIDE: usize = 8;

/// What the blocks so far weigh, in each half of the pixels.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct MeasuredWeights {
    halves: [HalfWeights; 2],
    /// Samples per pixel of all blocks.
    samples: u32,
    /// Samples per pixel after the last block.
    rest: u32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
struct HalfWeights {
    /// Of each sample of the last block; 0 before there is one.
    last: f64,
    /// Sum over a pixel's samples.
    sum: f64,
    /// Sum over a pixel's samples of the variance that their block has.
    variance: f64,
}

impl MeasuredWeights {
    /// Samples per pixel of all blocks.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// A step of so many samples per pixel more. Returns how many there are after the last block, where these are enough for
    /// another.
    pub fn add_step(&mut self, samples: u32) -> Option<u32> {
        self.rest += samples;
        (self.rest >= self.samples.max(LEAST_BLOCK)).then_some(self.rest)
    }

    /// Makes a block of all samples after the last, weighed by these variances. Returns its share of the mean for each half of
    /// the pixels.
    pub fn add_block(&mut self, variances: [f64; 2]) -> [f64; 2] {
        let count = f64::from(self.rest);
        let all = f64::from(self.samples) + count;
        self.samples += std::mem::take(&mut self.rest);
        let add = |half: &mut HalfWeights, variance: f64| {
            half.variance += count * variance;
            half.last = 1.0 / variance.max(half.variance / all / MOST_WEIGHT);
            half.sum += count * half.last;
            count * half.last / half.sum
        };
        let [first, second] = &mut self.halves;
        [add(first, variances[0]), add(second, variances[1])]
    }

    /// The share of the mean that so many samples after the last block have: they count for what that block's do.
    pub fn share_of_rest(&self, half: usize, samples: u32) -> f64 {
        let HalfWeights { last, sum, .. } = self.halves[half];
        match f64::from(samples) * last {
            _ if samples == 0 => 0.0,
            0.0 => 1.0,
            weight => weight / (sum + weight),
        }
    }
}

/// Half of the pixel with this index in tile order.
pub fn half_of_pixel(index: usize) -> usize {
    let within = index % (TILE_SIDE * TILE_SIDE);
    (within % TILE_SIDE + within / TILE_SIDE) % 2
}

/// The variance of a block's samples in each half of the pixels, which are in tile order: its mean over pixels and channels.
/// `None` where either is 0 or no number: no light has been seen there yet, or it does not vary.
pub fn variances_of_halves(film: &[FilmRadiance], samples: u32) -> Option<[f64; 2]> {
    let variances = [0, 1].map(|half| {
        let pixels = || pixels_of_half(film, half);
        let radiance = mean(pixels().map(|pixel| mean_rgb(pixel.mean)));
        let most = (MOST_DEVIATION * radiance).powi(2);
        let freedom = f64::from(samples.max(2) - 1);
        mean(pixels().map(|pixel| (mean_rgb(pixel.squared_deviation) / freedom).min(most)))
    });
    variances.iter().all(|variance| variance.is_finite() && *variance > 0.0).then_some(variances)
}

/// Those that lie within the picture.
fn pixels_of_half(film: &[FilmRadiance], half: usize) -> impl Iterator<Item = &FilmRadiance> {
    let of_half = film.iter().enumerate().filter(move |(index, _)| half_of_pixel(*index) == half);
    of_half.map(|(_, pixel)| pixel).filter(|pixel| pixel.sample_count > 0)
}

/// In the order that there is: sums depend on it.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

fn mean_rgb(color: [f32; 3]) -> f64 {
    color.into_iter().map(f64::from).sum::<f64>() / 3.0
}

/// A pixel of the weighed blocks.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct WeighedPixel {
    /// Weighed mean.
    pub mean: [f32; 3],
    /// Its variance, were weights fixed.
    pub variance: [f32; 3],
}

impl WeighedPixel {
    /// With these samples more, which have that share of the mean.
    pub fn with(&self, block: &FilmRadiance, samples: u32, share: f64) -> Self {
        let rest = 1.0 - share;
        let mean = |c: usize| f64::from(self.mean[c]) * rest + f64::from(block.mean[c]) * share;
        let variance = |c: usize| {
            let before = f64::from(self.variance[c]);
            let of_mean = f64::from(block.squared_deviation[c]) / (f64::from(samples) * (f64::from(samples) - 1.0));
            // A single sample is taken to vary as those before it.
            if samples > 1 { before * rest * rest + of_mean * share * share } else { before * rest }
        };
        Self { mean: [0, 1, 2].map(|c| mean(c) as f32), variance: [0, 1, 2].map(|c| variance(c) as f32) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest bias by crossed halves, as simulated before.
    const MOST_BIAS: f64 = 0.01;
    const PIXELS: usize = 64;

    fn pixel(mean: f64, squared_deviation: f64, sample_count: u32) -> FilmRadiance {
        let [mean, squared_deviation] = [mean, squared_deviation].map(|value| [value as f32; 3]);
        FilmRadiance { mean, sample_count, squared_deviation, hit_count: 0 }
    }

    /// Pixels with so many hits of that radiance each, all other samples being black.
    fn film(hits: &[u32], samples: u32, radiance: f64) -> Vec<FilmRadiance> {
        let of_hits = |&hits: &u32| {
            let (hits, count) = (f64::from(hits), f64::from(samples));
            pixel(radiance * hits / count, radiance * radiance * (hits - hits * hits / count), samples)
        };
        hits.iter().map(of_hits).collect()
    }

    #[test]
    fn halves_are_the_squares_of_a_chessboard() {
        let rows: Vec<Vec<_>> = (0..3).map(|y| (0..8).map(|x| half_of_pixel(64 * 5 + 8 * y + x)).collect()).collect();
        assert_eq!(rows, [vec![0, 1, 0, 1, 0, 1, 0, 1], vec![1, 0, 1, 0, 1, 0, 1, 0], vec![0, 1, 0, 1, 0, 1, 0, 1]]);
    }

    #[test]
    fn variances_are_those_of_each_half() {
        let mut film: Vec<_> = (0..128).map(|index| pixel(1.0, [14.0, 21.0][half_of_pixel(index)], 8)).collect();
        assert_eq!(variances_of_halves(&film, 8), Some([2.0, 3.0]));
        // Beyond the border there are no samples.
        film[64..].fill(pixel(0.0, 0.0, 0));
        assert_eq!(variances_of_halves(&film, 8), Some([2.0, 3.0]));
        // A single path counts for 100 times the mean at most.
        film[0] = pixel(1.0, 1.0e30, 8);
        assert_eq!(variances_of_halves(&film, 8), Some([(31.0 * 2.0 + 1.0e4) / 32.0, 3.0]));
        for unknown in [f64::NAN, f64::INFINITY] {
            film[0] = pixel(unknown, unknown, 8);
            assert_eq!(variances_of_halves(&film, 8), None);
        }
        let black: Vec<_> = (0..64).map(|index| pixel(0.0, half_of_pixel(index) as f64, 8)).collect();
        assert_eq!(variances_of_halves(&black, 8), None, "one half is black");
    }

    #[test]
    fn blocks_double_and_weigh_by_the_inverse_of_variance() {
        let mut weights = MeasuredWeights::default();
        assert_eq!([3, 4].map(|samples| weights.add_step(samples)), [None, None]);
        assert_eq!(weights.share_of_rest(0, 7), 1.0);
        assert_eq!(weights.add_step(1), Some(8));
        assert_eq!(weights.add_block([4.0, 1.0]), [1.0, 1.0]);
        assert_eq!((weights.samples(), weights.add_step(8)), (8, Some(8)));
        // 8 samples of weight 1/4 and 8 of 1; 8 of 1 and 8 of no more than 16 times that of the mean variance.
        let shares = weights.add_block([1.0, 1.0e-9]);
        assert!((shares[0] - 0.8).abs() < 1.0e-6 && (shares[1] - 32.0 / 33.0).abs() < 1.0e-6, "{shares:?}");
        assert!((weights.share_of_rest(0, 5) - 5.0 / 15.0).abs() < 1.0e-6);
        assert_eq!([weights.add_step(15), weights.add_step(1)], [None, Some(16)]);
    }

    #[test]
    fn pixels_have_the_weighed_mean_and_its_variance() {
        let first = WeighedPixel::default().with(&pixel(3.0, 56.0, 8), 8, 1.0);
        assert_eq!((first.mean, first.variance), ([3.0; 3], [1.0; 3]));
        let both = first.with(&pixel(7.0, 112.0, 8), 8, 0.25);
        assert_eq!((both.mean, both.variance), ([4.0; 3], [9.0 / 16.0 + 2.0 / 16.0; 3]));
        // One sample more has a share of a ninth, and nothing more a share of none.
        let more = first.with(&pixel(12.0, 0.0, 1), 1, 1.0 / 9.0);
        assert_eq!((more.mean, more.variance), ([4.0; 3], [8.0 / 9.0; 3]));
        assert_eq!(both.with(&pixel(0.0, 0.0, 0), 0, 0.0), both);
    }

    /// Relative bias of pictures of rare hits, so many in the first block of all pixels together.
    fn bias(hits: f64, is_crossed: bool) -> f64 {
        const RUNS: u32 = 20_000;
        let chance = hits / (f64::from(LEAST_BLOCK) * PIXELS as f64);
        let mut state = 1_u64;
        // PCG's generator of 64 bits, of which the upper ones are good.
        let mut is_hit = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 32) as f64) < chance * f64::from(u32::MAX)
        };
        let mut total = 0.0;
        for _ in 0..RUNS {
            let mut weights = MeasuredWeights::default();
            let mut pixels = [WeighedPixel::default(); PIXELS];
            let mut hits = [0; PIXELS];
            for samples in [8, 8, 16, 32] {
                hits.iter_mut().for_each(|hits| *hits += (0..samples).map(|_| u32::from(is_hit())).sum::<u32>());
                let Some(samples) = weights.add_step(samples) else { continue };
                let film = film(&hits, samples, 1.0 / chance);
                let Some([first, second]) = variances_of_halves(&film, samples) else { continue };
                let shares = weights.add_block(if is_crossed { [second, first] } else { [first, second] });
                for (index, (pixel, block)) in pixels.iter_mut().zip(&film).enumerate() {
                    *pixel = pixel.with(block, samples, shares[half_of_pixel(index)]);
                }
                hits.fill(0);
            }
            let rest = 64 - weights.samples();
            let shares = [0, 1].map(|half| weights.share_of_rest(half, rest));
            let film = film(&hits, rest.max(1), 1.0 / chance);
            let picture = pixels.iter().zip(&film).enumerate();
            let picture = picture.map(|(index, (pixel, block))| pixel.with(block, rest, shares[half_of_pixel(index)]));
            total += picture.map(|pixel| f64::from(pixel.mean[0])).sum::<f64>() / PIXELS as f64;
        }
        total / f64::from(RUNS) - 1.0
    }

    #[test]
    fn crossed_halves_hardly_bias_rare_hits() {
        for hits in [20.0, 5.0, 2.0] {
            let [crossed, own] = [true, false].map(|is_crossed| bias(hits, is_crossed));
            println!("{hits} hits in the first block: {crossed:+.4} crossed, {own:+.4} by their own variance");
            assert!(crossed.abs() < MOST_BIAS && own.abs() > MOST_BIAS, "{hits}");
        }
    }
}
