//! Twin of `glsl/include/guide/normalization/normalization_entry.glsl`.

use std::f64::consts::{PI, TAU};

use lodestar::settings::{Mix, Sampler};

use super::product::COSINE_SHARE;

/// Specialization constants of the kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Constant `SAMPLER`.
    pub sampler: Sampler,
    /// Constant `MIX`.
    pub mix: Mix,
    /// Constant `EPSILON`; `None` stands for 0.
    pub epsilon: Option<f64>,
    /// Constant `MAX_TRIES`.
    pub max_tries: u32,
    /// Constant `MIN_UNIFORM_SHARE`.
    pub min_uniform_share: f64,
}

/// Factors of a sampler: `NormalizationEntry` in GLSL. They multiply the function that the sampler follows. It is L cos
/// for rejection, L for inversion over the sphere, and L times the cosine's integral over the bin for inversion over
/// the hemisphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalizationEntry {
    /// Factor from the function that the sampler follows to the density of a guided direction.
    pub guide_scale: f64,
    /// Density of the uniform share and of the fallback.
    pub uniform_density: f64,
    /// Factor from the function that the sampler follows to a probability.
    pub acceptance_scale: f64,
    /// Share e of Eq. 8 and 9.
    pub uniform_share: f64,
}

impl Rules {
    /// Whether acceptances are mixed (Eq. 9), not densities.
    pub fn mixes_acceptances(&self) -> bool {
        self.mix == Mix::Acceptance
    }

    /// Probability of the component that draws uniformly, for the share e.
    pub fn unconditional_share(&self, e: f64) -> f64 {
        if self.mixes_acceptances() { self.min_uniform_share } else { e }
    }

    /// Probability that a proposal of the guide is accepted. Without any mix, the mean probability would be `c`.
    pub fn accepted(&self, c: f64, e: f64) -> f64 {
        if self.mixes_acceptances() { c + (1.0 - c) * e } else { c }
    }
}

/// Uniform share of Eq. 8. It needs the fewest proposals for a target whose mean over maximum is `c`.
pub fn optimal_uniform_share(c: f64) -> f64 {
    if c < 0.5 { (1.0 - 2.0 * c) / (2.0 - 2.0 * c) } else { 0.0 }
}

/// Share e of the rejection samplers.
pub fn uniform_share(c: f64, rules: &Rules) -> f64 {
    match (rules.sampler, rules.epsilon) {
        (Sampler::Rejection, _) => rules.min_uniform_share,
        (_, Some(epsilon)) => epsilon,
        _ if rules.mixes_acceptances() => optimal_uniform_share(c),
        _ => optimal_uniform_share(c).max(rules.min_uniform_share),
    }
}

/// Factors of a rejection sampler for a target with this normalizer, upper bound and uniform share.
pub fn factors_with_share(normalizer: f64, bound: f64, e: f64, rules: &Rules) -> NormalizationEntry {
    let accepted = rules.accepted((normalizer / (TAU * bound)).min(1.0), e);
    let all_fail = (1.0 - accepted).powi(rules.max_tries as i32);
    let unconditional = rules.unconditional_share(e);
    let guided = (1.0 - unconditional) * (1.0 - all_fail);
    let (guide_scale, acceptance_scale) = if rules.mixes_acceptances() {
        (guided / (TAU * accepted), (1.0 - e) / bound)
    } else {
        (guided / normalizer, 1.0 / bound)
    };
    let uniform_density = (unconditional + (1.0 - unconditional) * all_fail) / TAU;
    NormalizationEntry { guide_scale, uniform_density, acceptance_scale, uniform_share: e }
}

/// Factors of a rejection sampler for a target with this normalizer (its integral over the hemisphere) and upper bound.
pub fn rejection_factors(normalizer: f64, bound: f64, rules: &Rules) -> NormalizationEntry {
    if normalizer == 0.0 {
        return uniform_factors(rules);
    }
    let e = uniform_share((normalizer / (TAU * bound)).min(1.0), rules);
    factors_with_share(normalizer, bound, e, rules)
}

/// Factors for a table without light: all directions are uniform.
pub fn uniform_factors(rules: &Rules) -> NormalizationEntry {
    let unconditional = rules.unconditional_share(1.0);
    NormalizationEntry {
        guide_scale: (1.0 - unconditional) / TAU,
        uniform_density: unconditional / TAU,
        acceptance_scale: 0.0,
        uniform_share: 1.0,
    }
}

/// Factors of a sampler that chooses one of `bins` by its share of `total`, and a uniform direction within it.
pub fn inversion_factors(total: f64, bins: usize, rules: &Rules) -> NormalizationEntry {
    if total == 0.0 {
        return uniform_factors(rules);
    }
    let e = rules.min_uniform_share;
    NormalizationEntry {
        guide_scale: (1.0 - e) * bins as f64 / (4.0 * PI * total),
        uniform_density: e / TAU,
        acceptance_scale: 1.0 / total,
        uniform_share: e,
    }
}

/// Factors of the product sampler: the share of its descent, and the share of the cosine.
pub fn product_factors(rules: &Rules) -> NormalizationEntry {
    let e = rules.epsilon.unwrap_or(COSINE_SHARE);
    NormalizationEntry { guide_scale: 1.0 - e, uniform_density: 0.0, acceptance_scale: 0.0, uniform_share: e }
}

/// Normalizer and upper bound of a cell's `radiance`, given each bin's integral and maximum of the clamped cosine.
pub fn normalizer_and_bound(radiance: &[f32], integrals: &[f64], maxima: &[f64]) -> (f64, f64) {
    let products = |factors: &[f64]| radiance.iter().zip(factors).map(|(&l, f)| f64::from(l) * f).collect::<Vec<_>>();
    (products(integrals).iter().sum(), products(maxima).into_iter().fold(0.0, f64::max))
}
