//! Doc comments open by naming their subject, so that each is understood alone.

use crate::source::Source;

/// Folders that keep the rule.
const HELD: &[&str] = &["benches", "build", "examples", "glsl", "src", "tests"];

/// Openings that point at another sentence instead of naming a subject.
const REFUSED: &[&str] = &["The same", "Of", "Those", "These", "Likewise", "As", "That", "It", "Whose"];

/// Violations of the rule in the `sources` that it holds for, one line each.
pub fn violations(sources: &[Source]) -> Vec<String> {
    sources.iter().filter(|source| is_held(&source.path)).flat_map(violations_of).collect()
}

/// Whether the rule holds for the file at `path`.
fn is_held(path: &str) -> bool {
    HELD.iter().any(|held| path.strip_prefix(held).is_some_and(|rest| rest.is_empty() || rest.starts_with('/')))
}

fn violations_of(source: &Source) -> Vec<String> {
    let openings = if source.path.ends_with(".rs") { rust_openings(source) } else { glsl_opening(source) };
    let refused = openings.into_iter().filter(|(_, text)| is_refused(text));
    refused.map(|(line, text)| format!("{}:{line}: does not name its subject: {text}", source.path)).collect()
}

/// First lines of the doc comments in a Rust file, each with its line number.
fn rust_openings(source: &Source) -> Vec<(usize, &str)> {
    let mut openings = Vec::new();
    let mut previous = None;
    for (number, line) in (1..).zip(source.text.lines()) {
        let comment = doc_comment(line);
        if let Some((marker, text)) = comment
            && previous != Some(marker)
        {
            openings.push((number, text));
        }
        previous = comment.map(|(marker, _)| marker);
    }
    openings
}

/// Marker and text of a line that is a doc comment.
fn doc_comment(line: &str) -> Option<(&'static str, &str)> {
    let text = |marker: &'static str| Some((marker, line.trim_start().strip_prefix(marker)?.trim()));
    text("///").or_else(|| text("//!"))
}

/// First line of a GLSL file's header comment, if it has one.
fn glsl_opening(source: &Source) -> Vec<(usize, &str)> {
    let first = source.text.lines().next().and_then(|line| line.strip_prefix("//"));
    first.map(|text| (1, text.trim())).into_iter().collect()
}

fn is_refused(text: &str) -> bool {
    let mut words = text.split_whitespace();
    let is_question = words.next() == Some("What")
        && words.any(|word| matches!(word.trim_end_matches(['.', ',', ':', ';']), "is" | "are"));
    is_question || REFUSED.iter().any(|opening| opens_with(text, opening))
}

/// Whether `text` begins with the whole words of `opening`.
fn opens_with(text: &str, opening: &str) -> bool {
    text.strip_prefix(opening).is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

#[cfg(test)]
fn found(path: &str, text: &str) -> usize {
    violations(&[Source::new(path, text)]).len()
}

#[test]
fn bad_openings_are_found() {
    for (path, text) in [
        ("src/error.rs", "//! The same from those two parts of a scene that settings depend on."),
        ("src/film/weights.rs", "/// Of the second.\nfn f() {}"),
        ("src/film/weights.rs", "struct A {\n    /// Of their weights.\n    a: f32,\n}"),
        ("src/gpu/slots.rs", "/// Those that no submission uses."),
        ("src/gpu/slots.rs", "/// These."),
        ("src/gpu/slots.rs", "/// Likewise to the third vertex."),
        ("src/gpu/slots.rs", "/// As in Mitsuba."),
        ("src/scene/mod.rs", "/// That is sampled as its power asks for."),
        ("src/scene/mod.rs", "/// It, where it is text."),
        ("src/scene/mod.rs", "/// Whose clock is used."),
        ("src/image/mod.rs", "/// What a texture is looked up for."),
        ("src/image/mod.rs", "//! Images.\n\n/// What is wrong.\nfn f() {}"),
        ("src/image/mod.rs", "//! Images.\n/// Those that are small.\nfn f() {}"),
    ] {
        assert_eq!(found(path, text), 1, "{path}: {text}");
    }
}

#[test]
fn good_openings_are_not() {
    for (path, text) in [
        ("src/film/weights.rs", "/// Sum of squared weights, per pixel.\nfn f() {}"),
        ("src/film/weights.rs", "/// Reads a PLY file's header.\n/// Of two headers the first counts.\nfn f() {}"),
        ("src/film/weights.rs", "/// Offset in bytes.\n/// Ascending ids.\n/// Items.\nfn f() {}"),
        ("src/film/weights.rs", "// Of no importance here.\nlet a = \"/// Those\";"),
        ("src/scene/mod.rs", "/// Whether the surface emits.\nfn f() -> bool {}"),
        ("farm/film.rs", "/// Those of a file outside the folders."),
        ("srcs/mod.rs", "/// Those of a folder with a similar name."),
    ] {
        assert_eq!(found(path, text), 0, "{path}: {text}");
    }
}

#[test]
fn glsl_headers_open_with_their_first_line() {
    let opening = |text: &str| glsl_opening(&Source::new("glsl/a.glsl", text)).iter().any(|(_, text)| is_refused(text));
    assert!(opening("// What the grids are.\n#ifndef A"));
    assert!(!opening("// Radiance grid.\n// Of two cells the first.\n#ifndef A"));
    assert!(!opening("#version 460\n// Those that come later."));
}
