//! Sampling of directions towards an environment map: the map is cut into blocks, which are chosen by the light that
//! comes from them.

use std::f64::consts::{PI, TAU};

use glam::Vec3;
use rayon::prelude::*;

use super::alias_table::{AliasEntry, alias_table};
use crate::generated::constants;
use crate::scene::Image;
use crate::scene::texture::Texels;

/// Most columns and most rows of blocks.
const MOST_BLOCKS: [usize; 2] = [512, 256];
/// Blocks per texel of a small map, along each axis.
const BLOCKS_PER_TEXEL: usize = 4;
/// Every patch has a block, for a map has at least two texels along each axis.
const _: () = assert!(2 * BLOCKS_PER_TEXEL >= constants::ENVIRONMENT_PATCHES as usize);
/// Number of points along each axis at which the map is looked up in a block, at least.
const LEAST_POINTS: usize = 2;
const MOST_POINTS: usize = 16;
/// Share of its brightest texel that is added to a block's mean, so that every block that is not black can be drawn.
const BRIGHTEST_SHARE: f64 = 1.0 / 1024.0;

/// Latitude-longitude image. Texel centers are spread over the azimuth; the first and the last row are the poles.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    /// Number of texels in a row, at least 2.
    pub width: usize,
    /// Number of rows, at least 3, from the up axis down.
    pub height: usize,
    /// Radiance, finite and >= 0.
    pub texels: Vec<Vec3>,
}

impl EnvironmentMap {
    /// Map of an image, decoded to linear radiance.
    pub fn new(image: &Image) -> Self {
        let texels = match &image.texels {
            Texels::Bytes { srgb, data } => {
                let decode = if *srgb { linear_from_srgb } else { |byte| f32::from(byte) / 255.0 };
                data.iter().map(|&[r, g, b, _]| Vec3::from([r, g, b].map(decode))).collect()
            }
            Texels::Floats(data) => data.iter().map(|&[r, g, b, _]| Vec3::new(r, g, b)).collect(),
            Texels::Heights(data) => data.iter().copied().map(Vec3::splat).collect(),
        };
        Self { width: image.width as usize, height: image.height as usize, texels }
    }

    /// Mean of RGB of the brightest texel.
    pub fn brightest_texel(&self) -> f64 {
        f64::from(self.texels.iter().map(|texel| texel.element_sum()).fold(0.0, f32::max)) / 3.0
    }

    fn texel(&self, x: usize, y: usize) -> f64 {
        f64::from(self.texels[y * self.width + x % self.width].element_sum()) / 3.0
    }

    /// Mean of the color channels at coordinates in [0, 1], interpolated between four texels.
    pub fn mean_rgb(&self, u: f64, v: f64) -> f64 {
        let x = (u * self.width as f64 - 0.5).rem_euclid(self.width as f64);
        let y = v * (self.height - 1) as f64;
        let (x0, y0) = (x as usize, (y as usize).min(self.height - 2));
        let (across, down) = (x - x0 as f64, y - y0 as f64);
        let row = |y| self.texel(x0, y) * (1.0 - across) + self.texel(x0 + 1, y) * across;
        row(y0) * (1.0 - down) + row(y0 + 1) * down
    }

    /// Brightest of all texels that interpolation reads within a range of each coordinate.
    fn brightest(&self, u: [f64; 2], v: [f64; 2]) -> f64 {
        let column = |u: f64| (u * self.width as f64 - 0.5 + self.width as f64).floor() as usize;
        let row = |v: f64| (v * (self.height - 1) as f64) as usize;
        let rows = row(v[0])..=(row(v[1]) + 1).min(self.height - 1);
        let columns = column(u[0])..=column(u[1]) + 1;
        rows.flat_map(|y| columns.clone().map(move |x| self.texel(x, y))).fold(0.0, f64::max)
    }
}

fn linear_from_srgb(byte: u8) -> f32 {
    let value = f32::from(byte) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Blocks of a map, row by row. All blocks span equal parts of both coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentTable {
    /// Number of blocks in a row.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// One entry per block. The blocks of each patch have a table of their own.
    pub entries: Vec<AliasEntry>,
    /// Integral of the map's mean radiance (of RGB) over the directions of each patch, W/m^2. A patch whose blocks are drawn has
    /// a positive flux.
    pub fluxes: Vec<f64>,
}

impl EnvironmentTable {
    /// Table of `patch_side`^2 patches for a map with at least 2 x 3 texels.
    pub fn new(map: &EnvironmentMap, patch_side: usize) -> Self {
        let [columns, rows] =
            [(map.width, MOST_BLOCKS[0]), (map.height, MOST_BLOCKS[1])].map(|(n, most)| most.min(BLOCKS_PER_TEXEL * n));
        let blocks: Vec<Block> = (0..columns * rows)
            .into_par_iter()
            .map(|i| Block::new(map, [i % columns, i / columns], [columns, rows]))
            .collect();
        let weight = |block: &Block| (block.mean + BRIGHTEST_SHARE * block.brightest) * block.solid_angle;
        let weights: Vec<f64> = blocks.iter().map(weight).collect();
        let flux: f64 = blocks.iter().map(|block| block.mean * block.solid_angle).sum();
        let total: f64 = weights.iter().sum();
        let mut entries = vec![AliasEntry { threshold: 0, alias: 0, probability: 0.0 }; blocks.len()];
        let mut fluxes = Vec::with_capacity(patch_side * patch_side);
        for patch in 0..patch_side * patch_side {
            let members = blocks_of_patch(patch, patch_side, [columns, rows]);
            let of_patch: Vec<f64> = members.iter().map(|&block| weights[block]).collect();
            for (&block, entry) in members.iter().zip(alias_table(&of_patch)) {
                entries[block] = AliasEntry { alias: members[entry.alias as usize] as u32, ..entry };
            }
            fluxes.push(if total > 0.0 { flux * of_patch.iter().sum::<f64>() / total } else { 0.0 });
        }
        Self { columns, rows, entries, fluxes }
    }
}

/// Blocks of a patch, row by row. A block is part of the patch that holds its first corner.
fn blocks_of_patch(patch: usize, side: usize, [columns, rows]: [usize; 2]) -> Vec<usize> {
    let range = |at: usize, count: usize| (at * count).div_ceil(side)..((at + 1) * count).div_ceil(side);
    let across = range(patch % side, columns);
    range(patch / side, rows).flat_map(|y| across.clone().map(move |x| y * columns + x)).collect()
}

struct Block {
    mean: f64,
    brightest: f64,
    solid_angle: f64,
}

impl Block {
    fn new(map: &EnvironmentMap, at: [usize; 2], count: [usize; 2]) -> Self {
        let span = |axis: usize| [at[axis], at[axis] + 1].map(|edge| edge as f64 / count[axis] as f64);
        let (u, v) = (span(0), span(1));
        let points = |texels: usize, blocks: usize| (2 * texels).div_ceil(blocks).clamp(LEAST_POINTS, MOST_POINTS);
        let (across, down) = (points(map.width, count[0]), points(map.height, count[1]));
        let between = |ends: [f64; 2], i: usize, n: usize| ends[0] + (ends[1] - ends[0]) * (i as f64 + 0.5) / n as f64;
        let sum: f64 = (0..across * down)
            .map(|i| map.mean_rgb(between(u, i % across, across), between(v, i / across, down)))
            .sum();
        Self {
            mean: sum / (across * down) as f64,
            brightest: map.brightest(u, v),
            solid_angle: TAU * (u[1] - u[0]) * ((PI * v[0]).cos() - (PI * v[1]).cos()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: usize, height: usize, texel: impl Fn(usize) -> f32) -> EnvironmentMap {
        EnvironmentMap { width, height, texels: (0..width * height).map(|i| Vec3::splat(texel(i))).collect() }
    }

    #[test]
    fn a_white_map_sends_four_pi() {
        for (width, height) in [(2, 3), (7, 5), (600, 300), (1500, 701)] {
            for side in [1, 8] {
                let table = EnvironmentTable::new(&map(width, height, |_| 1.0), side);
                let flux: f64 = table.fluxes.iter().sum();
                assert!((flux / (4.0 * PI) - 1.0).abs() < 1.0e-12, "{flux}");
                assert_eq!((table.entries.len(), table.fluxes.len()), (table.columns * table.rows, side * side));
                let probability: f64 = table.entries.iter().map(|entry| f64::from(entry.probability)).sum();
                assert!((probability / (side * side) as f64 - 1.0).abs() < 1.0e-4, "{probability}");
            }
        }
    }

    #[test]
    fn blocks_are_drawn_wherever_the_map_is_not_black() {
        for (width, height, lit) in [(8, 5, 17), (40, 20, 0), (2048, 64, 2047), (2048, 1024, 512 * 2048 + 511)] {
            let map = map(width, height, |i| if i == lit { 1000.0 } else { 0.0 });
            let table = EnvironmentTable::new(&map, 1);
            let mut drawn = 0;
            for (i, entry) in table.entries.iter().enumerate() {
                let (column, row) = (i % table.columns, i / table.columns);
                let corner = |offset: f64, at: usize, count: usize| (at as f64 + offset) / count as f64;
                let offsets = [1.0e-6, 0.5, 1.0 - 1.0e-6];
                let mut points = offsets.iter().flat_map(|x| offsets.map(|y| (*x, y)));
                let is_lit = points
                    .any(|(x, y)| map.mean_rgb(corner(x, column, table.columns), corner(y, row, table.rows)) > 0.0);
                assert!(!is_lit || entry.probability > 0.0, "{width} x {height}: block {column}, {row}");
                drawn += usize::from(entry.probability > 0.0);
            }
            assert!(drawn > 0 && drawn <= 100, "{drawn} blocks for one texel");
        }
    }
}
