//! Twin of `glsl/include/normalization_entry.glsl`.

use std::f64::consts::TAU;

/// What the kernels take as specialization constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// `MAX_TRIES`
    pub max_tries: u32,
    /// `MIN_UNIFORM_SHARE`
    pub min_uniform_share: f64,
}

/// `NormalizationEntry` in GLSL.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalizationEntry {
    /// Times L cos: density of a guided direction.
    pub guide_scale: f64,
    /// Density of the uniform share and of the fallback.
    pub uniform_density: f64,
    /// Times L cos: probability that a proposal is accepted.
    pub acceptance_scale: f64,
    /// Probability of the uniform component.
    pub uniform_share: f64,
}

/// Eq. 8: the uniform share that spends the fewest proposals on a target whose mean over maximum is `c`.
pub fn optimal_uniform_share(c: f64, limits: Limits) -> f64 {
    let unbounded = if c < 0.5 { (1.0 - 2.0 * c) / (2.0 - 2.0 * c) } else { 0.0 };
    unbounded.max(limits.min_uniform_share)
}

/// The factors for a target of this normalizer, upper bound and uniform share.
pub fn factors_with_share(normalizer: f64, bound: f64, e: f64, max_tries: u32) -> NormalizationEntry {
    let c = (normalizer / (TAU * bound)).min(1.0);
    let all_fail = (1.0 - c).powi(max_tries as i32);
    NormalizationEntry {
        guide_scale: (1.0 - e) * (1.0 - all_fail) / normalizer,
        uniform_density: (e + (1.0 - e) * all_fail) / TAU,
        acceptance_scale: 1.0 / bound,
        uniform_share: e,
    }
}

/// The factors for a target of this normalizer (integral over the hemisphere) and this upper bound.
pub fn normalization_factors(normalizer: f64, bound: f64, limits: Limits) -> NormalizationEntry {
    let e = optimal_uniform_share((normalizer / (TAU * bound)).min(1.0), limits);
    factors_with_share(normalizer, bound, e, limits.max_tries)
}

/// Normalizer and upper bound of a cell's `radiance`, given each bin's integral and maximum of the clamped cosine.
pub fn normalizer_and_bound(radiance: &[f32], integrals: &[f64], maxima: &[f64]) -> (f64, f64) {
    let products = |factors: &[f64]| radiance.iter().zip(factors).map(|(&l, f)| f64::from(l) * f).collect::<Vec<_>>();
    (products(integrals).iter().sum(), products(maxima).into_iter().fold(0.0, f64::max))
}
