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

/// Estimate of a cell that falls back on its parent, whose mean counts as `fallback` targets.
pub fn blended(cell: LearnedRadiance, parent: Option<f64>, fallback: f64) -> f64 {
    parent.map_or(cell.mean, |parent| (cell.weight * cell.mean + fallback * parent) / (cell.weight + fallback))
}
