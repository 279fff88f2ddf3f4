//! Shipped code has no planted faults. Faults that tests must find are mutations of `tests/tampered`.

use crate::source::{Source, words};

/// Violations of the rule in `sources`, one line each.
pub fn violations(sources: &[Source]) -> Vec<String> {
    sources.iter().flat_map(violations_of).collect()
}

fn violations_of(source: &Source) -> impl Iterator<Item = String> {
    let found = words(&source.code).filter(|word| is_fault(word.text));
    found.map(|word| format!("{}:{}: names {}, but faults belong to tests", source.path, word.line, word.text))
}

/// Whether a name marks a planted fault. The word `fault` alone is allowed: it can be an error that the program meets.
fn is_fault(name: &str) -> bool {
    let name = name.to_lowercase();
    let is_mutation = name.split('_').any(|part| part.starts_with("mutat"));
    is_mutation || name.contains("tamper") || name.ends_with("_fault") || name.ends_with("_faults")
}

#[cfg(test)]
fn found(path: &str, text: &str) -> usize {
    violations(&[Source::new(path, text)]).len()
}

#[test]
fn bad_snippets_are_found() {
    for (path, text) in [
        ("src/settings.rs", "pub pdf_tamper: f32,"),
        ("src/settings.rs", "pub mis_fault: u32,"),
        ("glsl/include/variant.glsl", "const float PDF_TAMPER = 1.0;"),
        ("glsl/include/light.glsl", "if (MIS_FAULT == 1u) return 1.0;"),
        ("glsl/include/light.glsl", "return MUTATED ? 1.0 : weight;"),
    ] {
        assert_eq!(found(path, text), 1, "{path}: {text}");
    }
}

#[test]
fn good_snippets_are_not() {
    for (path, text) in [
        (
            "src/settings.rs",
            "/// The default, whatever fault there is.\nfn default_of() -> Self { Default::default() }",
        ),
        ("src/gpu/device.rs", "use super::fault_injection::{self, May};"),
        ("src/scene/ply.rs", "fn fault() {} let permutation = Fault::Lost;"),
        ("glsl/include/light.glsl", "// A page fault.\nfloat defaults;"),
    ] {
        assert_eq!(found(path, text), 0, "{path}: {text}");
    }
}
