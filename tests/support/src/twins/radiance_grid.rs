//! Twin of the arithmetic in `glsl/include/guide/grid/radiance_grid.glsl` and `glsl/kernels/learn/update_radiance.comp`.

/// Units of a target as large as the limit.
pub const FIXED_POINT_UNITS: f64 = 1_073_741_824.0;

/// No bin is sampled as if it held less than this share of its cell's mean.
pub const FLOOR_SHARE: f64 = 1.0 / 64.0;
/// Nor less than this share of the largest target.
pub const FLOOR_ABSOLUTE: f64 = 1.0e-12;

/// `LearnedRadiance` in GLSL.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LearnedRadiance {
    /// Mean radiance, before any floor.
    pub mean: f64,
    /// Decayed number of targets behind it.
    pub weight: f64,
}

/// Units of a target: saturated, then rounded up where its fraction exceeds `u`.
pub fn fixed_point(target: f64, target_limit: f64, u: f64) -> u64 {
    let units = (target / target_limit).clamp(0.0, 1.0) * FIXED_POINT_UNITS;
    units.floor() as u64 + u64::from(u < units.fract())
}

/// Eq. 7, at the rate count / (count + decayed count of before).
pub fn learn(before: LearnedRadiance, sum: f64, target_count: f64, decay: f64) -> LearnedRadiance {
    let weight = before.weight * decay + target_count;
    if target_count == 0.0 {
        return LearnedRadiance { mean: before.mean, weight };
    }
    LearnedRadiance { mean: (before.mean * before.weight * decay + sum) / weight, weight }
}

/// What a cell of such means is sampled by: lifted off zero.
pub fn floored(means: &[f64], target_limit: f64) -> Vec<f64> {
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    means.iter().map(|m| m.max(mean * FLOOR_SHARE).max(target_limit * FLOOR_ABSOLUTE)).collect()
}

/// What a larger cell has learned of a bin: the mean of what its cells have, each by how sure it is, and their weights' sum.
pub fn pooled(cells: &[LearnedRadiance], fallback: f64) -> LearnedRadiance {
    let share = |cell: &LearnedRadiance| cell.weight / (cell.weight + fallback);
    let shares: f64 = cells.iter().map(share).sum();
    let mean = cells.iter().map(|cell| share(cell) * cell.mean).sum::<f64>() / shares.max(f64::MIN_POSITIVE);
    LearnedRadiance { mean, weight: cells.iter().map(|cell| cell.weight).sum() }
}

/// The estimate of a cell that falls back on its parent's, as if that were the mean of `fallback` targets.
pub fn blended(cell: LearnedRadiance, parent: Option<f64>, fallback: f64) -> f64 {
    parent.map_or(cell.mean, |parent| (cell.weight * cell.mean + fallback * parent) / (cell.weight + fallback))
}
