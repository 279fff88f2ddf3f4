//! Noise estimates of tiles, which decide where sampling goes on. CPU only.
//!
//! Whether a pixel gets another sample depends on the samples it has, so a mean of such samples is biased: pictures
//! that end by noise are consistent, not unbiased. The bias falls with the target.

use std::ops::Range;

use serde::Serialize;

/// Samples per pixel before noise is estimated: two samples for each part of the two halves.
pub const LEAST_SAMPLES: u32 = 32;

/// Sums over the pixels of a tile; each term is averaged over the color channels
/// (`glsl/kernels/noise/judge_noise.comp`).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TileNoise {
    /// Sum of the relative variances of the pixels' mean radiances. Each variance is divided by the square of the
    /// pixel's mean or of the tile's mean, whichever is larger.
    pub squared_error: f64,
    /// Sum of the pixels' mean radiances.
    pub radiance: f64,
}

/// How close a picture is to its noise target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseReport {
    /// Relative error at or below which a tile ends.
    pub target: f32,
    /// Estimated relative error of the noisiest tile; `None` before noise is estimated.
    pub largest: Option<f64>,
    /// Root mean square of the relative errors of all tiles; `None` before noise is estimated.
    pub mean: Option<f64>,
    /// Share of the pixels that are still sampled, in [0, 1].
    pub sampled_share: f64,
}

impl NoiseReport {
    /// Report for a picture whose noise is not estimated yet.
    pub fn unknown(target: f32) -> Self {
        Self { target, largest: None, mean: None, sampled_share: 1.0 }
    }
}

/// Square tiles that cover a window, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Tiles {
    width: u32,
    height: u32,
    side: u32,
}

impl Tiles {
    /// Tiles of `side` pixels that cover a window of `width` x `height` pixels. The last tile of a row or column may
    /// reach beyond the window.
    pub fn new(width: u32, height: u32, side: u32) -> Self {
        Self { width, height, side }
    }

    fn columns(&self) -> usize {
        self.width.div_ceil(self.side) as usize
    }

    fn rows(&self) -> usize {
        self.height.div_ceil(self.side) as usize
    }

    /// Number of tiles.
    pub fn count(&self) -> usize {
        self.columns() * self.rows()
    }

    /// Number of the tile's pixels that lie in the window.
    pub fn pixels(&self, tile: usize) -> u32 {
        let extent = |index: usize, size: u32| (size - index as u32 * self.side).min(self.side);
        extent(tile % self.columns(), self.width) * extent(tile / self.columns(), self.height)
    }

    /// Estimated relative error of each tile: the root mean square over its pixels. The error of a tile darker than the
    /// picture is multiplied by the square root of (tile radiance / picture radiance), else dark corners would never
    /// end. Dammertz et al. 2010 also divide by the root of radiance.
    ///
    /// A tile in which no light has been seen has error 0. A value that is not a number gives an infinite error.
    pub fn relative_errors(&self, noise: &[TileNoise]) -> Vec<f64> {
        let of_picture = noise.iter().map(|tile| tile.radiance).sum::<f64>() / self.all_pixels() as f64;
        let error = |(index, tile): (usize, &TileNoise)| {
            let pixels = f64::from(self.pixels(index));
            let brightness = (tile.radiance / pixels / of_picture).min(1.0);
            let error = (tile.squared_error / pixels * brightness).sqrt();
            match tile.squared_error {
                0.0 => 0.0,
                _ if error.is_nan() => f64::INFINITY,
                _ => error,
            }
        };
        noise.iter().enumerate().map(error).collect()
    }

    /// Whether each tile goes on: its error or a neighbor's is above the target. A neighbor's samples may have met
    /// light that this tile's estimate has missed.
    pub fn going_on(&self, errors: &[f64], target: f64) -> Vec<bool> {
        let is_noisy: Vec<bool> = errors.iter().map(|&error| error > target).collect();
        let around = |at: usize, end: usize| -> Range<usize> { at.saturating_sub(1)..(at + 2).min(end) };
        let goes_on = |tile: usize| {
            let (column, row) = (tile % self.columns(), tile / self.columns());
            let mut rows = around(row, self.rows());
            rows.any(|y| around(column, self.columns()).any(|x| is_noisy[y * self.columns() + x]))
        };
        (0..self.count()).map(goes_on).collect()
    }

    /// Number of pixels in the window.
    pub fn all_pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 x 2 tiles; the last column is 4 pixels wide and the last row 2 pixels high.
    const TILES: Tiles = Tiles { width: 20, height: 10, side: 8 };

    #[test]
    fn tiles_share_out_the_window() {
        assert_eq!(TILES.count(), 6);
        let pixels: Vec<_> = (0..6).map(|tile| TILES.pixels(tile)).collect();
        assert_eq!(pixels, [64, 64, 32, 16, 16, 8]);
        assert_eq!(u64::from(pixels.iter().sum::<u32>()), TILES.all_pixels());
    }

    #[test]
    fn errors_are_relative_and_those_of_dark_tiles_count_for_less() {
        let noise: Vec<_> = (0..6)
            .map(|tile| {
                let pixels = f64::from(TILES.pixels(tile));
                let radiance = if tile == 1 { 0.25 } else { 4.0 };
                TileNoise { squared_error: 0.01 * pixels, radiance: radiance * pixels }
            })
            .collect();
        let of_picture = (64.0 * 0.25 + 136.0 * 4.0) / 200.0;
        let errors = TILES.relative_errors(&noise);
        assert!((errors[0] - 0.1).abs() < 1e-12, "bright");
        assert!((errors[5] - 0.1).abs() < 1e-12, "a small tile is like a whole one");
        assert!((errors[1] - 0.1 * f64::sqrt(0.25 / of_picture)).abs() < 1e-12, "dark");
    }

    #[test]
    fn units_of_radiance_do_not_matter() {
        let tile = |t: usize, unit: f64| TileNoise { squared_error: t as f64, radiance: unit * (1.0 + t as f64) };
        let [ours, theirs] = [1.0, 1e3].map(|unit| (0..6).map(|t| tile(t, unit)).collect::<Vec<_>>());
        let pairs = TILES.relative_errors(&ours).into_iter().zip(TILES.relative_errors(&theirs));
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn what_is_black_ends_and_what_is_no_number_does_not() {
        assert_eq!(TILES.relative_errors(&[TileNoise::default(); 6]), [0.0; 6]);
        let mut noise = [TileNoise { squared_error: 0.0, radiance: 1.0 }; 6];
        noise[3].squared_error = f64::INFINITY;
        assert_eq!(TILES.going_on(&TILES.relative_errors(&noise), 1.0), [true, true, false, true, true, false]);
        noise[3].squared_error = f64::NAN;
        assert_eq!(TILES.going_on(&TILES.relative_errors(&noise), 1.0), [true, true, false, true, true, false]);
    }

    #[test]
    fn neighbors_of_noisy_tiles_go_on() {
        let tiles = Tiles::new(5 * 8, 4 * 8, 8);
        let mut errors = vec![0.01; tiles.count()];
        assert!(tiles.going_on(&errors, 0.01).iter().all(|&goes_on| !goes_on), "at the target they end");
        errors[0] = 0.02;
        let going_on = |errors: &[f64]| {
            let on = tiles.going_on(errors, 0.01);
            (0..tiles.count()).filter(|&tile| on[tile]).collect::<Vec<_>>()
        };
        assert_eq!(going_on(&errors), [0, 1, 5, 6]);
        (errors[0], errors[13]) = (0.0, 0.02);
        assert_eq!(going_on(&errors), [7, 8, 9, 12, 13, 14, 17, 18, 19]);
    }
}
