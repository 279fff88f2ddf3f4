//! What a rejection sampler costs: `glsl/include/guide/samplers/rejection_mix.glsl`.

use super::normalization_entry::Rules;

/// Proposals that a sample takes on average at the share e, where each is accepted with probability `c` before any mix: one
/// in the uniform share, in the guide as many as it takes up to `max_tries`, and then the fallback.
pub fn mean_tries(c: f64, e: f64, rules: &Rules) -> f64 {
    let failure = 1.0 - rules.accepted(c, e);
    let guide: f64 = (0..=rules.max_tries).map(|failures| failure.powi(failures as i32)).sum();
    let unconditional = rules.unconditional_share(e);
    unconditional + (1.0 - unconditional) * guide
}
