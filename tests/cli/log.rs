//! Option `--log json`: one JSON object per line on standard error.

use std::process::Output;

use lodestar::image::exr::read_layer;
use serde_json::Value;

use crate::support::{Folder, SCENE};

const JSON: [&str; 2] = ["--log", "json"];

/// Lines of a log. Every line must be an object with an event and a time.
#[track_caller]
fn parsed(text: &str) -> Vec<Value> {
    let lines: Vec<Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}"))).collect();
    assert!(lines.iter().all(|line| line["event"].is_string() && line["time"].as_f64().unwrap() > 1.7e9), "{text}");
    lines
}

fn log(output: &Output) -> Vec<Value> {
    assert!(output.stdout.is_empty());
    parsed(&String::from_utf8(output.stderr.clone()).unwrap())
}

fn events<'a>(lines: &'a [Value], event: &str) -> Vec<&'a Value> {
    lines.iter().filter(|line| line["event"] == event).collect()
}

fn number(line: &Value, name: &str) -> f64 {
    line[name].as_f64().unwrap_or_else(|| panic!("{line} lacks {name}"))
}

#[test]
fn every_line_parses_and_the_counts_add_up() {
    let folder = Folder::new();
    let output = folder.run(
        &[&["render", "scene.xml", "--spp", "12", "-o", "a.exr", "-o", "b.png", "--stats", "s.json"], &JSON[..]]
            .concat(),
    );
    assert!(output.status.success());
    let lines = log(&output);
    let [start] = events(&lines, "start")[..] else { panic!("{lines:?}") };
    assert_eq!((&start["version"], &start["samples"]), (&env!("CARGO_PKG_VERSION").into(), &0.into()));
    assert_eq!((&start["length"]["spp"], &start["settings"]["sampler"]), (&12.into(), &"product".into()));
    assert!(start["scene"].as_str().unwrap().ends_with("/scene.xml"), "{start}");
    assert_eq!((start["device"].is_string(), &start["files"]), (true, &serde_json::json!(["a.exr", "b.png"])));

    let (steps, stats) = (events(&lines, "step"), folder.read_json("s.json"));
    assert_eq!(steps.len(), stats["steps"].as_array().unwrap().len());
    let mut samples = 0.0;
    for (step, counted) in steps.iter().zip(stats["steps"].as_array().unwrap()) {
        samples += number(counted, "spp");
        assert_eq!((number(step, "samples"), number(step, "paths")), (samples, samples * 16.0 * 12.0));
        let rate = number(step, "paths") / number(step, "seconds");
        assert!((number(step, "paths_per_second") / rate - 1.0).abs() < 1e-9, "{step}");
        assert!((0.0..=1.0).contains(&number(step, "light_hit_rate")) && step["noise"].is_null(), "{step}");
    }
    let files: Vec<_> = events(&lines, "written").iter().map(|line| line["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["a.exr", "b.png"]);
    let end = lines.last().unwrap();
    assert_eq!((&end["event"], &end["reason"]), (&"end".into(), &"samples".into()));
    assert_eq!((number(end, "samples"), &end["files"]), (12.0, &start["files"]));
    assert_eq!(end["paths"], steps.last().unwrap()["paths"]);
}

#[test]
fn the_last_line_names_the_reason() {
    let folder = Folder::new();
    let reason = |arguments: &[&str]| {
        let output = folder.run(&[&["render", "scene.xml", "-o", "a.exr"], &JSON[..], arguments].concat());
        let lines = log(&output);
        (output.status.code(), lines.last().unwrap().clone())
    };
    for (arguments, expected) in
        [(&["--spp", "8"][..], "samples"), (&["--time", "0.2s"], "time"), (&["--noise", "0.3"], "noise")]
    {
        let (code, end) = reason(arguments);
        assert_eq!((code, &end["event"], &end["reason"]), (Some(0), &"end".into(), &expected.into()), "{end}");
    }
    for arguments in [&["-D", "grey=1"][..], &["--device", "voodoo"], &["-o", "missing/b.exr"]] {
        let (code, end) = reason(arguments);
        assert_eq!((code, &end["event"], &end["reason"]), (Some(1), &"end".into(), &"failed".into()), "{end}");
        assert!(end["message"].as_str().unwrap().len() > 10, "{end}");
    }
}

#[test]
fn noise_is_in_the_steps() {
    let folder = Folder::new();
    let output = folder.run(&[&["render", "scene.xml", "--noise", "0.05", "-o", "a.exr"], &JSON[..]].concat());
    let lines = log(&output);
    let end = lines.last().unwrap();
    assert_eq!((number(&end["noise"], "target"), number(&end["noise"], "sampled_share")), (0.05, 0.0));
    assert!(
        number(&end["noise"], "largest") <= 0.05 && events(&lines, "step").iter().all(|step| step["noise"].is_object())
    );
}

#[test]
fn a_signal_is_a_reason_and_a_resumed_render_goes_on_counting() {
    let folder = Folder::new();
    let files = ["-o", "a.exr", "--checkpoint", "a.ckpt", "--spp", "1000000", "--sampler", "bsdf"];
    let mut running = folder.start(&[&["render", "scene.xml"], &files[..], &JSON].concat());
    running.wait_for_line(r#""event":"step""#);
    running.signal("INT");
    let (code, rest) = running.wait();
    let lines = parsed(&rest);
    let end = lines.last().unwrap();
    assert_eq!((code, &end["event"], &end["reason"]), (Some(130), &"end".into(), &"stopped".into()), "{end}");
    let paths: f64 =
        read_layer(&folder.path("a.exr"), "samples").unwrap().pixels.iter().map(|pixel| f64::from(pixel[0])).sum();
    assert_eq!(number(end, "paths"), paths);

    let spp = (number(end, "samples") + 64.0).to_string();
    let resumed = log(&folder.run(&[&["resume", "a.ckpt", "--spp", &spp], &JSON[..]].concat()));
    let [start] = events(&resumed, "start")[..] else { panic!("{resumed:?}") };
    assert!(number(start, "samples") > 0.0 && number(start, "samples") <= number(end, "samples"), "{start}");
    assert_eq!(number(resumed.last().unwrap(), "paths"), spp.parse::<f64>().unwrap() * 16.0 * 12.0);
}

#[test]
fn warnings_are_lines_and_a_quiet_log_has_nothing_else() {
    let folder = Folder::new();
    let gloss = r#"type="diffuse"><float name="gloss" value="1"/>"#;
    folder.write("scene.xml", &SCENE.replace(r#"type="diffuse">"#, gloss));
    let render = |more: &[&str]| {
        log(&folder.run(&[&["render", "scene.xml", "--spp", "1", "-o", "a.exr"], &JSON[..], more].concat()))
    };
    let lines = render(&[]);
    assert!(events(&lines, "warning")[0]["message"].as_str().unwrap().contains("`gloss`"));
    let quiet = render(&["--quiet"]);
    assert_eq!((quiet.len(), &quiet[0]["event"]), (1, &"warning".into()));
    let failed = render(&["--quiet", "--device", "voodoo"]);
    assert_eq!(failed.last().unwrap()["reason"], "failed");
}
