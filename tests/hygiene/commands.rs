//! Commands of the justfile and of the workflows run scripts and tests that the repository has.

use std::path::Path;

/// File with the commands that contributors type.
const JUSTFILE: &str = "justfile";
/// Folder of the workflows.
const WORKFLOWS: &str = ".github/workflows";
/// Folders whose files the commands name. What a command makes lies elsewhere.
const FOLDERS: [&str; 8] = [".ci/", "addons/", "benches/", "docs/", "farm/", "packages/", "scenes/", "tests/"];

/// Paths and texts of all files with commands.
pub fn read(root: &Path) -> Vec<(String, String)> {
    let entries = std::fs::read_dir(root.join(WORKFLOWS)).unwrap().map(Result::unwrap);
    let mut paths: Vec<_> =
        entries.map(|entry| format!("{WORKFLOWS}/{}", entry.file_name().to_str().unwrap())).collect();
    paths.push(JUSTFILE.into());
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read_to_string(root.join(path)).unwrap())).collect()
}

/// Scripts and tests that the commands name and the repository lacks. `exists` tells whether it has a file or folder.
pub fn violations(texts: &[(String, String)], exists: &dyn Fn(&str) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in texts {
        for (line, text) in (1..).zip(text.lines()) {
            found.extend(missing(text, exists).map(|name| format!("{path}:{line}: there is no {name}")));
        }
    }
    found
}

/// Names in a line that lead nowhere.
fn missing<'a>(line: &'a str, exists: &'a dyn Fn(&str) -> bool) -> impl Iterator<Item = &'a str> {
    let words = line.split(|c: char| c.is_whitespace() || "\"'`;:()".contains(c)).filter(|word| !word.is_empty());
    let before = [""].into_iter().chain(words.clone());
    before.zip(words).filter_map(move |(before, word)| {
        let word = word.trim_end_matches(['.', ',']);
        let script = word.trim_start_matches("./");
        let is_path = word.starts_with("./") || FOLDERS.iter().any(|folder| word.starts_with(folder));
        let is_lost = if before == "--test" {
            // A braced word is an argument of the recipe.
            !word.contains('{') && !["rs", "/main.rs"].iter().any(|end| exists(&test_file(word, end)))
        } else {
            is_path && !exists(script)
        };
        is_lost.then_some(word)
    })
}

/// Path of the test `name`, whose file ends so.
fn test_file(name: &str, end: &str) -> String {
    if end == "rs" { format!("tests/{name}.rs") } else { format!("tests/{name}{end}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(line: &str) -> Vec<String> {
        let here =
            ["setup.sh", "tests/long.sh", "tests/render/main.rs", "tests/examples.rs", "docs/build.sh", ".ci/run"];
        violations(&[("justfile".into(), format!("all:\n    {line}\n"))], &|path| here.contains(&path))
    }

    #[test]
    fn what_there_is_may_be_run() {
        for line in [
            "./setup.sh && cargo test --release --test render --test examples",
            "LODESTAR_FULL=1 tests/long.sh today; docs/build.sh",
            "run: .ci/run",
            "cargo test --release --test {{ file }} -- {{ word }}",
            "cp target/release/lodestar packages",
        ] {
            assert_eq!(found(line), Vec::<String>::new(), "{line}");
        }
    }

    #[test]
    fn what_is_lost_is_found() {
        for (line, lost) in [
            ("./set-up.sh", "./set-up.sh"),
            ("tests/short.sh all", "tests/short.sh"),
            ("run: .ci/runs", ".ci/runs"),
            ("cargo test --release --test renders", "renders"),
        ] {
            assert_eq!(found(line), [format!("justfile:2: there is no {lost}")], "{line}");
        }
    }
}
