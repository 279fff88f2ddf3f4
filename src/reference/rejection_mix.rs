//! Twin of `glsl/include/rejection_mix.glsl`.

use glam::DVec3;

use super::equal_area::direction_bin;
use super::normalization_entry::NormalizationEntry;

/// Density of `wi` where a cell holds `radiance` in a map of `resolution` bins a side, under the sampler that `entry` drives.
pub fn pdf_rejection_mix(
    radiance: &[f32],
    resolution: u32,
    nb: DVec3,
    n: DVec3,
    wi: DVec3,
    entry: &NormalizationEntry,
) -> f64 {
    let bin_radiance = f64::from(radiance[direction_bin(wi, resolution) as usize]);
    let uniform = if wi.dot(n) > 0.0 { entry.uniform_density } else { 0.0 };
    entry.guide_scale * bin_radiance * wi.dot(nb).max(0.0) + uniform
}

/// Proposals that a sample takes on average, where each is accepted with probability `c`: one in the uniform share, in the
/// guide as many as it takes up to `max_tries`, and then the fallback.
pub fn mean_tries(c: f64, uniform_share: f64, max_tries: u32) -> f64 {
    let guide: f64 = (0..=max_tries).map(|failures| (1.0 - c).powi(failures as i32)).sum();
    uniform_share + (1.0 - uniform_share) * guide
}
