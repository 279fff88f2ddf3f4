//! Formats of scenes: their names and the extensions of their files. `read.rs` has their readers.

/// Every format as (name, extensions of its files in lower case). The first one is that of files with other extensions.
pub(super) const FORMATS: [(&str, &[&str]); 4] = [
    ("Mitsuba's XML", &["xml"]),
    ("glTF 2.0", &["gltf", "glb"]),
    ("USD", &["usd", "usda", "usdc", "usdz"]),
    ("pbrt-v4", &["pbrt"]),
];

/// Names of all formats of scenes, as a help shows them.
pub fn format_names() -> String {
    joined(&FORMATS.map(|(name, _)| name.to_owned()))
}

/// Names of all formats with the extensions of their files, as messages show them.
pub(super) fn with_extensions() -> String {
    let with_extensions = |(name, extensions): (&str, &[&str])| {
        let extensions: Vec<_> = extensions.iter().map(|extension| format!(".{extension}")).collect();
        format!("{name} ({})", extensions.join(", "))
    };
    joined(&FORMATS.map(with_extensions))
}

/// Words such as `a, b or c`.
fn joined(words: &[String]) -> String {
    match words {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        words => words.concat(),
    }
}
