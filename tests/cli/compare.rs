//! Subcommand `lodestar compare`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use lodestar::film::Picture;
use lodestar::film::write_picture;

use crate::support::assert_sentence;

fn lodestar(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lodestar"));
    command.args(arguments);
    command
}

fn write(folder: &Path, name: &str, width: u32, value: f32) -> String {
    let path = folder.join(name);
    write_row(&path, width, value);
    path.into_os_string().into_string().unwrap()
}

/// Writes a picture of one row with a constant value.
pub fn write_row(path: &Path, width: u32, value: f32) {
    let count = width as usize;
    let picture = Picture {
        width,
        height: 1,
        offset: [0, 0],
        full_size: [width, 1],
        radiance: vec![[value; 3]; count],
        variance: vec![[0.0; 3]; count],
        sample_count: vec![1; count],
        hit_count: vec![1; count],
        sums: vec![],
        has_background: false,
        view: None,
        albedo: vec![[0.0; 3]; count],
        normal: vec![[0.0; 3]; count],
        depth: vec![1.0; count],
    };
    write_picture(path, &picture, &[]).unwrap();
}

#[test]
fn compare_prints_the_metrics() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = [("a.exr", 2.0), ("b.exr", 1.0)].map(|(name, value)| write(folder.path(), name, 3, value));
    let output = lodestar(&["compare", &a, &b, "--json"]).output().unwrap();
    assert!(output.status.success());
    let metrics: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&metrics["mae"], &metrics["mean_ratio"]), (&1.0.into(), &2.0.into()));
    let output = lodestar(&["compare", &a, &b]).output().unwrap();
    let names = ["mae_ldr", "mae", "mse", "relmse", "relmse_trim", "mean_ratio"];
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().map(|line| line.split(' ').next().unwrap()).collect::<Vec<_>>(), names);
}

#[test]
fn compare_refuses_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let good = write(folder.path(), "good.exr", 3, 1.0);
    let wide = write(folder.path(), "wide.exr", 4, 1.0);
    let dark = write(folder.path(), "dark.exr", 3, f32::NAN);
    let run = |other: &str| lodestar(&["compare", &good, other]).output().unwrap();
    assert_sentence(&run(&wide), 1, &["good.exr", "wide.exr", "3x1", "4x1"]);
    assert_sentence(&run(&dark), 1, &["dark.exr", "3 of 3 pixels"]);
    assert_sentence(&run("missing.exr"), 1, &["missing.exr: cannot be read"]);
    std::fs::write(folder.path().join("text.exr"), "no picture").unwrap();
    assert_sentence(
        &run(&folder.path().join("text.exr").to_string_lossy()),
        1,
        &["text.exr: it is not a whole EXR image"],
    );
}

#[test]
fn a_reader_that_has_left_is_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let a = write(folder.path(), "a.exr", 3, 1.0);
    for arguments in [&["compare", &a, &a] as &[&str], &["compare", &a, &a, "--json"], &["--help"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = lodestar(arguments).stdout(writer).stderr(Stdio::piped()).output().unwrap();
        assert!(output.status.success(), "{arguments:?}");
        assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// Reference pictures of another renderer can be read. They are not part of the repository: `LODESTAR_REFERENCES` names
/// their folder.
#[test]
fn reads_the_pictures_of_another_renderer() {
    let Some(folder) = std::env::var_os("LODESTAR_REFERENCES").map(PathBuf::from) else {
        eprintln!("skipped: LODESTAR_REFERENCES is not set");
        return;
    };
    let path = |name: &str| folder.join(name).into_os_string().into_string().unwrap();
    let (a, b) = (path("cornell-box.mean.exr"), path("cornell-box-hard.mean.exr"));
    let output = lodestar(&["compare", &a, &b, "--json"]).output().unwrap();
    let metrics: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // The expected figures come from an independent implementation that reads the files with the other renderer's own
    // code.
    let expected = [
        ("mae_ldr", 0.072_656_541_704_536_1),
        ("mae", 0.131_004_451_965_593_18),
        ("mse", 1.044_153_451_810_258),
        ("relmse", 0.124_286_302_428_997_46),
        ("relmse_trim", 0.117_390_046_841_290_26),
        ("mean_ratio", 0.614_579_725_419_931),
    ];
    for (name, expected) in expected {
        let value = metrics[name].as_f64().unwrap();
        assert!((value / expected - 1.0).abs() < 1e-6, "{name}: {value} is not {expected}");
    }
}
