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
        radiance: vec![[value; 3]; count],
        sample_count: vec![1; count],
        hit_count: vec![1; count],
        ..Picture::empty(width, 1, [0, 0], [width, 1])
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
    let names = ["mae_ldr", "mae", "mse", "relmse", "relmse_trim", "smape", "flip", "mean_ratio"];
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().map(|line| line.split(' ').next().unwrap()).collect::<Vec<_>>(), names);
}

/// Several pictures come as a list, and `--layer` measures another layer.
#[test]
fn several_pictures_have_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, reference] =
        [("a.exr", 2.0), ("b.exr", 4.0), ("r.exr", 1.0)].map(|(name, value)| write(folder.path(), name, 3, value));
    let output = lodestar(&["compare", &a, &b, &reference, "--json"]).output().unwrap();
    let list: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&list[0]["picture"], &list[0]["mae"]), (&a.clone().into(), &1.0.into()));
    assert_eq!((&list[1]["picture"], &list[1]["mae"]), (&b.clone().into(), &3.0.into()));
    let text = String::from_utf8(lodestar(&["compare", &a, &b, &reference]).output().unwrap().stdout).unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!((lines[0], lines[9], lines[10], lines.len()), (&a[..], "", &b[..], 19), "{text}");
    let output = lodestar(&["compare", &a, &reference, "--layer", "albedo", "--json"]).output().unwrap();
    let errors: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(errors["mae"], 1.0, "a black albedo against 1");
    assert_sentence(
        &lodestar(&["compare", &a, &reference, "--layer", "glow"]).output().unwrap(),
        1,
        &["no layer glow"],
    );
    assert_sentence(&lodestar(&["compare", &a]).output().unwrap(), 2, &["name two files or more: A.exr REF.exr"]);
}

/// Chromium, if it is installed.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    if found.is_none() {
        eprintln!("skipped: there is no Chromium to open the page with");
    }
    found
}

/// Text of the page at the address, after its script has run.
fn opened(browser: &str, page: &Path, wanted: &str) -> String {
    let profile = tempfile::tempdir().unwrap();
    let mut command = Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom"]);
    command.arg(format!("--user-data-dir={}", profile.path().display()));
    let output = command.arg(format!("file://{}{wanted}", page.display())).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_report_works_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, reference] =
        [("a.exr", 2.0), ("b.exr", 1.25), ("r.exr", 1.0)].map(|(name, value)| write(folder.path(), name, 3, value));
    let page = folder.path().join("report.html");
    let html = page.to_str().unwrap();
    assert!(lodestar(&["compare", &a, &b, &reference, "--html", html]).output().unwrap().status.success());
    let missing = folder.path().join("missing/report.html");
    let output = lodestar(&["compare", &a, &b, "--html", missing.to_str().unwrap()]).output().unwrap();
    assert_sentence(&output, 1, &["report.html: cannot be written", "mkdir -p"]);
    let Some(browser) = browser() else { return };
    let text = opened(browser, &page, "#view=difference&measure=squared&picture=2");
    for part in [
        "data-ready=\"true\"",
        "3 × 1 pixels",
        "squared error of b.exr",
        "Error map of a.exr",
        "Error map of b.exr",
        // The second picture has the least error: (1.25 - 1)^2.
        "<td class=\"best\" title=\"the least error\">0.06250</td>",
        // The map's brightest color is the first picture's error: (2 - 1)^2.
        "id=\"ramp-end\">1.000<",
    ] {
        assert!(text.contains(part), "the page lacks {part}: {}", &text[text.len().saturating_sub(3000)..]);
    }
    assert!(opened(browser, &page, "").contains("a.exr on the left, r.exr on the right"));
    let text = std::fs::read_to_string(&page).unwrap().replace("</body>", &format!("<script>{KEYS}</script></body>"));
    std::fs::write(&page, text).unwrap();
    let text = opened(browser, &page, "");
    let (_, log) = text.split_once("data-log=\"").expect("the keys were pressed");
    let log: Vec<_> = log.split('"').next().unwrap_or_default().split('|').collect();
    let pixel = "pixel 1, 0   absolute error 0.2500";
    assert_eq!(log, ["b.exr", "r.exr", "absolute error of b.exr", "52", "larger", pixel]);
}

/// Script that presses keys once the page is ready, and notes what the page shows.
const KEYS: &str = r#"
const timer = setInterval(() => {
  if (!document.body.dataset.ready) return;
  clearInterval(timer);
  const log = [], press = (key, more = {}, on = document.body) =>
    on.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
  press("2"); press("f"); log.push($("left").textContent);
  press(" "); log.push($("left").textContent);
  press("d"); log.push($("left").textContent);
  press("s"); press("]"); log.push($("division").value);
  const before = zoom(); press("+"); log.push(zoom() > before ? "larger" : "not larger");
  press("Home"); press("ArrowRight", { shiftKey: true }, $("stage")); press("ArrowLeft", { shiftKey: true }, $("stage"));
  log.push($("readout").textContent.split("\n")[0]);
  document.body.dataset.log = log.join("|");
}, 20);
"#;

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
