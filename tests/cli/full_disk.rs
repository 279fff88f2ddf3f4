//! Full disks and limits on file sizes: the old file stays, and the message names the cause.

use std::fs;
use std::process::{Command, Output};

use crate::support::{Folder, SHARED_CACHE, assert_quiet_success, assert_sentence};

/// Runs the program in a shell, after the shell commands `setup` and before the shell commands `check`.
fn run_after(folder: &Folder, shell: &[&str], setup: &str, arguments: &[&str], check: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_lodestar");
    let script = format!("{setup}; {program} \"$@\"; code=$?; {check}; exit $code");
    let command = [shell, &["sh", "-c", &script, "sh"], arguments].concat();
    let mut process = Command::new(command[0]);
    process.args(&command[1..]).current_dir(folder.path("")).env("XDG_CACHE_HOME", SHARED_CACHE);
    process.env_remove("LODESTAR_DEVICE").output().unwrap()
}

const RENDER: [&str; 10] =
    ["render", "scene.xml", "--quiet", "--spp", "8", "--width", "64", "--height", "64", "--seed=1"];

/// Folder with a checkpoint and pictures of an earlier render.
fn with_old_files() -> Folder {
    let folder = Folder::new();
    fs::create_dir(folder.path("full")).unwrap();
    folder.render(&["--spp", "8", "--width", "64", "--height", "64", "-o", "old.exr", "--checkpoint", "full/a.ckpt"]);
    fs::remove_file(folder.path("stats.json")).unwrap();
    for name in ["a.exr", "b.png", "s.json"] {
        folder.write(&format!("full/{name}"), "old");
    }
    folder
}

/// A limit on file sizes is an error, and the old file stays. `ulimit -f 1` allows 512 bytes per file.
#[test]
fn a_limit_on_file_sizes_is_an_error_and_the_old_file_stays() {
    let folder = with_old_files();
    let checkpoint = fs::read(folder.path("full/a.ckpt")).unwrap();
    let before = folder.names();
    for name in ["full/a.exr", "full/b.png"] {
        let output = run_after(&folder, &[], "ulimit -f 1", &[&RENDER[..], &["-o", name]].concat(), ":");
        assert_sentence(&output, 1, &[name, ": cannot be written: File too large"]);
        assert_eq!(fs::read_to_string(folder.path(name)).unwrap(), "old");
    }
    let resume = ["resume", "full/a.ckpt", "--spp", "24", "--checkpoint-every", "0.001", "-o", "b.exr", "--quiet"];
    // This limit is enough for the picture.
    let output = run_after(&folder, &[], "ulimit -f 2000", &resume, ":");
    let said = String::from_utf8(output.stderr).unwrap();
    let lines: Vec<_> = said.lines().collect();
    let [warning, error] = lines[..] else { panic!("{said}") };
    let sentence = "full/a.ckpt: cannot be written: File too large";
    assert!(warning.starts_with(&format!("lodestar: warning: {sentence}")) && warning.ends_with("goes on"), "{said}");
    assert!(error.starts_with(&format!("lodestar: error: {sentence}")), "{said}");
    assert_eq!(output.status.code(), Some(1));
    assert!(fs::read(folder.path("full/a.ckpt")).unwrap() == checkpoint);
    fs::remove_file(folder.path("b.exr")).unwrap();
    assert_eq!(folder.names(), before, "nothing else is left");
}

/// A full disk is an error, and the old file stays. The test mounts a disk of its own, if the system lets a user do so.
#[test]
fn a_full_disk_is_an_error_and_the_old_file_stays() {
    let namespace = ["unshare", "--user", "--map-root-user", "--mount"];
    let mount = "mount -t tmpfs -o size=8m tmpfs disk";
    let probe = Command::new(namespace[0]).args(&namespace[1..]).args(["true"]).output();
    if !probe.is_ok_and(|output| output.status.success()) {
        println!("skipped, for the system allows no disks of one's own");
        return;
    }
    let folder = with_old_files();
    fs::create_dir(folder.path("disk")).unwrap();
    fs::create_dir(folder.path("seen")).unwrap();
    // The space left is smaller than any of the files.
    let fill = "cp full/* disk/ && head -c 9999999 /dev/zero > disk/rest 2>/dev/null";
    let setup = format!("{mount} && {fill}");
    let copy = "rm disk/rest; rm -f seen/*; cp disk/* seen/; ls -A disk > names";
    for (arguments, name) in [
        ([&RENDER[..], &["-o", "disk/a.exr"]].concat(), "disk/a.exr"),
        ([&RENDER[..], &["-o", "disk/b.png"]].concat(), "disk/b.png"),
        ([&RENDER[..], &["-o", "kept.exr", "--stats", "disk/s.json"]].concat(), "disk/s.json"),
        (["resume", "disk/a.ckpt", "--spp", "24", "-o", "kept.exr", "--quiet"].to_vec(), "disk/a.ckpt"),
        (["merge", "parts/a.exr", "parts/b.exr", "-o", "disk/a.exr"].to_vec(), "disk/a.exr"),
    ] {
        write_parts(&folder);
        let output = run_after(&folder, &namespace, &setup, &arguments, copy);
        assert_sentence(&output, 1, &[name, ": cannot be written: No space left on device"]);
        for old in ["a.ckpt", "a.exr", "b.png", "s.json"] {
            let [before, after] =
                ["full", "seen"].map(|place| fs::read(folder.path(&format!("{place}/{old}"))).unwrap());
            assert!(before == after, "{name}: {old}");
        }
        assert_eq!(fs::read_to_string(folder.path("names")).unwrap(), "a.ckpt\na.exr\nb.png\ns.json\n", "{name}");
    }
    assert!(folder.path("kept.exr").exists());
}

/// Writes two pictures to merge.
fn write_parts(folder: &Folder) {
    if folder.path("parts").exists() {
        return;
    }
    fs::create_dir(folder.path("parts")).unwrap();
    for (name, offset) in [("parts/a.exr", "0"), ("parts/b.exr", "8")] {
        let arguments = [&RENDER[..], &["-o", name, "--sample-offset", offset]].concat();
        assert_quiet_success(&folder.run(&arguments));
    }
}
