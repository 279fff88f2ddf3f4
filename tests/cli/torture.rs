//! Every operation of a render on its files fails once, or for good, or is the last thing that the process does. Whatever happens, each
//! file is the old one or the new one, and the same command again ends with the picture of an undisturbed render.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use lodestar::film::read_picture;
use lodestar::session::checkpoint::Checkpoint;
use support::tier;

use crate::resume::assert_same_picture;
use crate::support::{Folder, assert_quiet_success};

/// A render of a few steps that writes each of its files after each of them.
const RENDER: [&str; 18] = [
    "render",
    "scene.xml",
    "--quiet",
    "--spp",
    "16",
    "-o",
    "a.exr",
    "-o",
    "b.png",
    "--stats",
    "s.json",
    "--checkpoint",
    "a.ckpt",
    "--checkpoint-every",
    "0.000001",
    "--write-every",
    "0.000001",
    "--overwrite",
];

/// The library that counts and fails operations; `None` where there is no C compiler.
pub fn library() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let build = || {
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/torture.c");
        let library = PathBuf::from(concat!(env!("CARGO_TARGET_TMPDIR"), "/torture.so"));
        let output =
            Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library).args([source, "-ldl"]).output();
        let output = output.ok()?;
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Some(library)
    };
    BUILT.get_or_init(build).as_deref()
}

/// Runs the render with the operation number `at` disturbed by `deed`. Returns the names of the operations.
fn tortured(folder: &Folder, library: &Path, deed: &str, at: usize) -> (Output, Vec<String>) {
    let log = tempfile::NamedTempFile::new().unwrap();
    let mut command = folder.command(&RENDER);
    command.env("LD_PRELOAD", library).env("TORTURE_FOLDER", folder.path("").canonicalize().unwrap());
    command.env("TORTURE_LOG", log.path()).env("TORTURE_DEED", deed).env("TORTURE_AT", at.to_string());
    let output = command.output().unwrap();
    let names =
        fs::read_to_string(log.path()).unwrap().lines().map(|line| line.split(' ').nth(1).unwrap().into()).collect();
    (output, names)
}

/// Folder with the files of an earlier render of other samples, without its checkpoint.
fn with_old_files(old: &BTreeMap<&'static str, Vec<u8>>) -> Folder {
    let folder = Folder::new();
    old.iter().for_each(|(name, bytes)| fs::write(folder.path(name), bytes).unwrap());
    folder
}

/// Checks that each file is whole. Files beside them are temporary.
fn check_files(folder: &Folder, what: &str) {
    read_picture(&folder.path("a.exr")).unwrap_or_else(|error| panic!("{what}: {error}"));
    image::open(folder.path("b.png")).unwrap_or_else(|error| panic!("{what}: {error}"));
    folder.read_json("s.json");
    for name in folder.names() {
        let is_known = ["a.exr", "b.png", "s.json", "scene.xml", "a.ckpt", ".a.ckpt.lock"].contains(&&name[..]);
        assert!(is_known || name.starts_with('.') && name.ends_with(".part"), "{what}: {name}");
    }
    let checkpoint = folder.path("a.ckpt");
    if checkpoint.exists() {
        Checkpoint::read(&checkpoint).unwrap_or_else(|error| panic!("{what}: {error}"));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn every_operation_on_files_may_fail_or_be_the_last() {
    let Some(library) = library() else {
        println!("skipped: there is no C compiler `cc`");
        return;
    };
    let folder = Folder::new();
    let old = ["--spp", "8", "--seed", "5", "-o", "a.exr", "-o", "b.png"];
    folder.render(&old);
    let names = [("a.exr", "a.exr"), ("b.png", "b.png"), ("s.json", "stats.json")];
    let old: BTreeMap<_, _> = names.map(|(name, at)| (name, fs::read(folder.path(at)).unwrap())).into();
    folder.render(&["--spp", "16", "-o", "whole.exr"]);
    let whole = folder.path("whole.exr");

    let (output, operations) = tortured(&with_old_files(&old), library, "none", 0);
    assert_quiet_success(&output);
    let count = operations.len();
    for name in ["open64", "write", "fsync", "flock", "rename", "unlink"] {
        assert!(operations.iter().any(|found| found == name), "no {name} in {operations:?}");
    }
    println!("{count} operations on files");
    let places: Vec<_> = match tier::is_full() {
        true => (1..=count).collect(),
        // A few of each kind of operation.
        false => (1..=count).step_by(count.div_ceil(5)).collect(),
    };
    let (mut failures, mut kills) = (0, 0);
    for deed in ["once", "on", "kill"] {
        for &at in &places {
            let folder = with_old_files(&old);
            let (output, operations) = tortured(&folder, library, deed, at);
            let said = String::from_utf8_lossy(&output.stderr);
            let what =
                format!("{deed} {at} ({}): {said}", operations.get(at - 1).map_or("never reached", String::as_str));
            match output.status.code() {
                Some(0) => {}
                Some(1) => {
                    failures += 1;
                    assert!(said.lines().last().is_some_and(|line| line.starts_with("lodestar: error: ")), "{what}");
                }
                None if deed == "kill" => kills += 1,
                other => panic!("{other:?}: {what}"),
            }
            assert!(!said.contains("panicked") && said.lines().all(|line| line.starts_with("lodestar: ")), "{what}");
            check_files(&folder, &what);
            let again = folder.run(&RENDER);
            assert!(again.status.success(), "{what}, then {}", String::from_utf8_lossy(&again.stderr));
            assert_same_picture(&folder.path("a.exr"), &whole);
            check_files(&folder, &what);
            let left: Vec<_> = folder.names().into_iter().filter(|name| name.starts_with('.')).collect();
            // A file that a killed process has left without content, or that could not be removed, stays for some seconds.
            let is_empty = |name: &String| fs::read(folder.path(name)).unwrap().is_empty();
            assert!(deed != "kill" || left.iter().all(is_empty), "{what}: {left:?}");
        }
    }
    println!("{failures} failures, {kills} kills");
    assert!(failures > 0 && kills == places.len());
}
