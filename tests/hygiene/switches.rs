//! Exactly one file distinguishes samplers, and exactly one distinguishes learners.

use crate::source::{Source, words};

/// File that declares the constants.
const DECLARATION: &str = "glsl/include/shared/variant.glsl";
/// Constants, each with the file that may name it.
const SWITCHES: [(&str, &str); 2] =
    [("SAMPLER", "glsl/include/guide/samplers/sampler.glsl"), ("LEARNER", "glsl/include/path/learning.glsl")];

/// Violations of the rule in `sources`, one line each.
pub fn violations(sources: &[Source]) -> Vec<String> {
    SWITCHES.iter().flat_map(|(name, owner)| violations_of(sources, name, owner)).collect()
}

fn violations_of(sources: &[Source], name: &str, owner: &str) -> Vec<String> {
    let others = sources.iter().filter(|source| source.path != owner && source.path != DECLARATION);
    let found = others.flat_map(|source| words(&source.code).map(move |word| (source, word)));
    let named = found.filter(|(_, word)| word.text == name);
    named.map(|(source, word)| format!("{}:{}: names {name}: ask what {owner} tells", source.path, word.line)).collect()
}

#[test]
fn a_second_switch_is_found() {
    let found = |path: &str, text: &str| violations(&[Source::new(path, text)]).len();
    assert_eq!(found("glsl/include/path/guiding.glsl", "if (SAMPLER == SAMPLER_BSDF) return;"), 1);
    assert_eq!(found("glsl/kernels/a.comp", "bool a = LEARNER == LEARNER_SARSA && SAMPLER != 0u;"), 2);
    assert_eq!(found("glsl/include/path/guiding.glsl", "if (is_product()) return SAMPLER_PRODUCT; // SAMPLER"), 0);
    for (name, owner) in SWITCHES {
        assert_eq!(found(owner, name) + found(DECLARATION, name), 0, "{name}");
    }
}
