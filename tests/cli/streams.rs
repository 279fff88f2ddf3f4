//! Standard output is for results and standard error for messages. Either may be closed.

use std::process::Stdio;

use crate::support::{Folder, SCENE, SHARED_CACHE, assert_quiet_success};

const TINY: [&str; 8] = ["render", "scene.xml", "--width", "8", "--height", "8", "--sampler", "bsdf"];

/// Folder with a scene that has an unknown parameter.
fn folder_with_a_warning() -> Folder {
    let folder = Folder::new();
    folder
        .write("scene.xml", &SCENE.replace(r#"type="diffuse">"#, r#"type="diffuse"><float name="gloss" value="1"/>"#));
    folder
}

#[test]
fn progress_is_plain_lines_where_nobody_watches() {
    let folder = Folder::new();
    let output = folder.run(&TINY);
    assert!(output.status.success() && output.stdout.is_empty());
    let lines = String::from_utf8(output.stderr).unwrap();
    assert!(lines.ends_with('\n') && !lines.contains('\r') && !lines.contains('\u{1b}'), "{lines:?}");
    let lines: Vec<_> = lines.lines().collect();
    let (last, progress) = lines.split_last().unwrap();
    assert!(last.starts_with("wrote ") && last.contains(".exr"), "{lines:?}");
    assert!(progress.iter().all(|line| line.contains("/12 spp, ") && line.contains(" Mpaths/s")), "{lines:?}");
    assert!(progress.last().unwrap().starts_with("12/12 spp, "), "{lines:?}");
}

#[test]
fn quiet_is_quiet_but_for_warnings() {
    let quiet = [&TINY[..], &["--quiet"]].concat();
    assert_quiet_success(&Folder::new().run(&quiet));
    let output = folder_with_a_warning().run(&quiet);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.lines().count() == 1, "{said}");
    assert!(said.starts_with("lodestar: warning: scene.xml:14: ") && said.contains("`gloss`"), "{said}");
}

#[test]
fn help_and_version_go_to_standard_output() {
    let folder = Folder::new();
    for arguments in [&["--help"][..], &["--version"], &["render", "--help"], &["help", "render"]] {
        let output = folder.run(arguments);
        assert!(output.status.success() && output.stderr.is_empty() && !output.stdout.is_empty(), "{arguments:?}");
    }
    assert_eq!(folder.run(&["--version"]).stdout, format!("lodestar {}\n", env!("CARGO_PKG_VERSION")).into_bytes());
}

/// Messages that nobody reads are no failure. A panic would give the exit code 101.
#[test]
fn a_reader_that_has_left_changes_no_exit_code() {
    let folder = folder_with_a_warning();
    for (arguments, code) in [
        (&TINY[..], 0),
        (&["render", "missing.xml"], 1),
        (&["render", "--fast"], 2),
        (&[], 2),
        (&["devices"], 0),
        (&["devices", "--json"], 0),
        (&["render", "--help"], 0),
    ] {
        let closed = || Stdio::from(std::io::pipe().unwrap().1);
        let status = folder.command(arguments).stdout(closed()).stderr(closed()).status().unwrap();
        assert_eq!(status.code(), Some(code), "{arguments:?}");
    }
    assert!(folder.path("scene.exr").exists() || folder.names().iter().any(|name| name.ends_with(".exr")));
}

/// Exit codes do not change when both streams are closed, as by `lodestar ... >&- 2>&-`.
#[test]
fn closed_streams_change_no_exit_code() {
    let folder = folder_with_a_warning();
    for (arguments, code) in [(&TINY[..], 0), (&["render", "missing.xml"], 1), (&["devices"], 0)] {
        let program = folder.command(arguments);
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", r#"exec "$0" "$@" <&- >&- 2>&-"#]).arg(program.get_program()).args(program.get_args());
        shell.current_dir(program.get_current_dir().unwrap()).env("XDG_CACHE_HOME", SHARED_CACHE);
        assert_eq!(shell.status().unwrap().code(), Some(code), "{arguments:?}");
    }
}
