//! Cost of a rejection sampler: `glsl/include/guide/samplers/rejection_mix.glsl`.

use super::normalization_entry::Rules;

/// Mean number of proposals per sample, for the share e and the mean probability `c` that a proposal is accepted before
/// any mix. The uniform share takes one proposal. The guide takes up to `max_tries`, and then the fallback.
pub fn mean_tries(c: f64, e: f64, rules: &Rules) -> f64 {
    let failure = 1.0 - rules.accepted(c, e);
    let guide: f64 = (0..=rules.max_tries).map(|failures| failure.powi(failures as i32)).sum();
    let unconditional = rules.unconditional_share(e);
    unconditional + (1.0 - unconditional) * guide
}
