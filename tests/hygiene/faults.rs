//! What ships has no faults on purpose: those that tests must find are mutations of `tests/tampered`.

use crate::source::{Source, words};

/// Has calls of the driver fail, for the tests of what is left after one.
const OF_THE_DRIVER: &str = "src/gpu/fault_injection.rs";
const ITS_MODULE: &str = "fault_injection";

/// What is wrong with `sources`, one line each.
pub fn violations(sources: &[Source]) -> Vec<String> {
    let may_name = |source: &Source, word: &str| word == ITS_MODULE && source.path.starts_with("src/gpu/");
    let of_source = |source: &Source| -> Vec<String> {
        let found = words(&source.code).filter(|word| is_fault(word.text) && !may_name(source, word.text));
        found
            .map(|word| format!("{}:{}: names {}: faults belong to tests", source.path, word.line, word.text))
            .collect()
    };
    sources.iter().filter(|source| source.path != OF_THE_DRIVER).flat_map(of_source).collect()
}

/// Whether the name has one of the words for a fault among its parts.
fn is_fault(name: &str) -> bool {
    let lower = name.to_lowercase();
    let is_part = |part: &str| matches!(part, "fault" | "faults" | "faulty");
    name.contains("Fault")
        || ["tamper", "mutat"].iter().any(|word| lower.contains(word))
        || lower.split('_').any(is_part)
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
        ("src/kernels.rs", "enum MisFault { Exact }"),
        ("src/renderer/mod.rs", "use crate::gpu::fault_injection;"),
        ("src/gpu/device.rs", "fn fault() {}"),
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
        (OF_THE_DRIVER, "enum Fault { Lost }"),
        ("glsl/include/light.glsl", "// A page fault.\nfloat defaults;"),
    ] {
        assert_eq!(found(path, text), 0, "{path}: {text}");
    }
}
