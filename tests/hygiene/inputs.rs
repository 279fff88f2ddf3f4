//! Files that others have made are opened in one place, which waits for nobody and reads no more than a file's length.

use crate::source::Source;

/// Calls that open a file for reading.
const OPENERS: [&str; 9] = [
    "File::open(",
    "OpenOptions::",
    "fs::read(",
    "fs::read_to_string(",
    "image::open(",
    "ImageReader::open(",
    "from_file(",
    "tobj::load_obj(",
    "gltf::import(",
];

/// Files that open others for reading, and why these are no strangers' files.
const EXCEPTIONS: [(&str, &str); 10] = [
    ("src/inputs.rs", "this is the one place"),
    ("src/gpu/pipeline_cache.rs", "it reads what it has written, with a seal, in the user's cache"),
    ("src/gpu/survey.rs", "it reads facts of the machine from /sys and /etc"),
    ("src/renderer/memory_needs.rs", "it reads /proc/meminfo"),
    ("src/session/statistics.rs", "it reads /proc/self/status"),
    ("src/cli/interrupt.rs", "it reads /proc/self/status"),
    ("src/view/guard.rs", "it reads 16 bytes of /dev/urandom"),
    ("src/reproduce/figure6.rs", "it reads its own records"),
    ("src/reproduce/record.rs", "it reads its own records"),
    ("src/reproduce/stage.rs", "it reads its own records"),
];

/// Lines of `src` that open a file elsewhere, one line each.
pub fn violations(sources: &[Source]) -> Vec<String> {
    let open = sources.iter().filter(|source| EXCEPTIONS.iter().all(|(path, _)| *path != source.path));
    open.flat_map(|source| {
        // Tests stand at the end of a file.
        let lines = source.code.lines().take_while(|line| !line.starts_with("mod tests"));
        let found = lines.enumerate().filter(|(_, line)| OPENERS.iter().any(|opener| line.contains(opener)));
        found.map(|(index, _)| {
            format!("{}:{}: opens a file; use crate::inputs, which opens regular files only", source.path, index + 1)
        })
    })
    .collect()
}

/// Exceptions that are none any more, one line each.
pub fn stale_exceptions(sources: &[Source]) -> Vec<String> {
    let opens = |path: &str| {
        let source = sources.iter().find(|source| source.path == path);
        source
            .is_some_and(|source| OPENERS.iter().chain(&["File::options("]).any(|opener| source.code.contains(opener)))
    };
    let stale = EXCEPTIONS.iter().filter(|(path, _)| !opens(path));
    stale.map(|(path, _)| format!("{path}: opens no file any more; take it from the list")).collect()
}

#[test]
fn openers_are_found_outside_tests_only() {
    let found = |path: &str, text: &str| violations(&[Source::new(path, text)]).len();
    assert_eq!(found("src/scene/a.rs", "let file = File::open(path)?;\nlet text = std::fs::read_to_string(path)?;"), 2);
    assert_eq!(found("src/scene/a.rs", "// File::open(path)\n#[cfg(test)]\nmod tests {\nfs::read(path)\n}"), 0);
    assert_eq!(found("src/inputs.rs", "File::open(path)"), 0);
    assert_eq!(stale_exceptions(&[]).len(), EXCEPTIONS.len());
}
