//! Twin of the arithmetic in `glsl/include/guide/grid/radiance_grid.glsl` and in
//! `glsl/kernels/learn/update_radiance.comp`.

/// Number of fixed-point units of a target as large as the limit.
pub const FIXED_POINT_UNITS: f64 = 1_073_741_824.0;

/// Smallest share of its cell's mean that a bin is sampled with.
pub const FLOOR_SHARE: f64 = 1.0 / 64.0;
/// Smallest share of the largest target that a bin is sampled with.
pub const FLOOR_ABSOLUTE: f64 = 1.0e-12;

/// Learned radiance of a bin: `LearnedRadiance` in GLSL.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LearnedRadiance {
    /// Mean radiance, before any floor.
    pub mean: f64,
    /// Decayed number of targets in the mean.
    pub weight: f64,
}

/// Fixed-point units of a target: clamped, then rounded up if its fraction exceeds `u`.
pub fn fixed_point(target: f64, target_limit: f64, u: f64) -> u64 {
    let units = (target / target_limit).clamp(0.0, 1.0) * FIXED_POINT_UNITS;
    units.floor() as u64 + u64::from(u < units.fract())
}

/// Update by Eq. 7, at the rate count / (count + decayed earlier count).
pub fn learn(before: LearnedRadiance, sum: f64, target_count: f64, decay: f64) -> LearnedRadiance {
    let weight = before.weight * decay + target_count;
    if target_count == 0.0 {
        return LearnedRadiance { mean: before.mean, weight };
    }
    LearnedRadiance { mean: (before.mean * before.weight * decay + sum) / weight, weight }
}

/// Values that a cell with these means is sampled by: no less than the floors.
pub fn floored(means: &[f64], target_limit: f64) -> Vec<f64> {
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    means.iter().map(|m| m.max(mean * FLOOR_SHARE).max(target_limit * FLOOR_ABSOLUTE)).collect()
}

/// Learned radiance of a parent cell's bin: the mean over its cells, each weighted by its confidence, and the sum of
/// their weights.
pub fn pooled(cells: &[LearnedRadiance], fallback: f64) -> LearnedRadiance {
    let share = |cell: &LearnedRadiance| cell.weight / (cell.weight + fallback);
    let shares: f64 = cells.iter().map(share).sum();
    let mean = cells.iter().map(|cell| share(cell) * cell.mean).sum::<f64>() / shares.max(f64::MIN_POSITIVE);
    LearnedRadiance { mean, weight: cells.iter().map(|cell| cell.weight).sum() }
}

/// Estimate of a bin that falls back on its parent cell, whose estimate counts as `fallback` targets.
pub fn blended(bin: LearnedRadiance, parent: Option<f64>, fallback: f64) -> f64 {
    parent.map_or(bin.mean, |parent| (bin.weight * bin.mean + fallback * parent) / (bin.weight + fallback))
}

/// Factors on the estimates of a parent cell's bins, by how bright the cell has found the blocks that they lie in:
/// `glsl/include/guide/grid/block_scales.glsl`. The prior scale of a block counts as `evidence` targets. There are `side` x `side`
/// bins.
pub fn block_scales(cell: &[LearnedRadiance], parent: &[f64], side: usize, evidence: f64) -> Vec<f64> {
    let block_of = |bin: usize, blocks: usize| [bin % side, bin / side].map(|at| at * blocks / side);
    let scale_of = |bin: usize| {
        [1, 2, 4, 8].into_iter().fold(1.0, |scale, blocks| {
            let inside = (0..cell.len()).filter(|&other| block_of(other, blocks) == block_of(bin, blocks));
            let inside: Vec<_> = inside.collect();
            let sum = |value: &dyn Fn(usize) -> f64| inside.iter().map(|&other| value(other)).sum::<f64>();
            let prior = evidence * sum(&|other| parent[other]) / inside.len() as f64;
            let found = sum(&|other| cell[other].weight * cell[other].mean);
            let expected = sum(&|other| cell[other].weight * parent[other]);
            if expected + prior > 0.0 { (found + prior * scale) / (expected + prior) } else { scale }
        })
    };
    (0..cell.len()).map(scale_of).collect()
}
