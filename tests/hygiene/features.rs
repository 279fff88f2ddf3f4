//! Crates that only the program needs. A program that uses the library compiles none of them.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Features of the program, which are off for who uses the library alone.
const OF_THE_PROGRAM: [&str; 3] = ["cli", "reproduce", "view"];

/// Crates of the program that a library build compiles, and crates of the program that not even the program has.
pub fn violations(root: &Path) -> Vec<String> {
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).expect("a manifest");
    let own: BTreeSet<String> = OF_THE_PROGRAM.iter().flat_map(|feature| crates_of(&manifest, feature)).collect();
    assert!(own.len() > 4, "{own:?}");
    let (library, program) = (tree(root, &["--no-default-features"]), tree(root, &[]));
    let compiled = own.intersection(&library).map(|name| format!("{name}: the library alone compiles it"));
    let missing = own.difference(&program).map(|name| format!("{name}: the program lacks it"));
    compiled.chain(missing).collect()
}

/// Crates that a feature of the manifest brings.
fn crates_of(manifest: &str, feature: &str) -> Vec<String> {
    let line = manifest.lines().find_map(|line| line.strip_prefix(feature)?.trim().strip_prefix('='));
    let line = line.unwrap_or_else(|| panic!("Cargo.toml has no feature {feature} in one line"));
    line.split('"').filter_map(|part| part.strip_prefix("dep:")).map(str::to_owned).collect()
}

/// Names of all crates that a build with these arguments compiles into the library or the program.
fn tree(root: &Path, arguments: &[&str]) -> BTreeSet<String> {
    let cargo = ["tree", "--offline", "--package", "lodestar-render", "--edges", "normal", "--prefix", "none"];
    let output = Command::new(env!("CARGO")).args(cargo).args(arguments).current_dir(root).output().expect("cargo");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
}

#[test]
fn the_crates_of_a_feature_are_read() {
    let manifest = "[features]\ndefault = [\"cli\"]\ncli = [\"dep:clap\", \"view\", \"dep:indicatif\"]\n";
    assert_eq!(crates_of(manifest, "cli"), ["clap", "indicatif"]);
}
