//! Option `render --profile`.

use std::process::Output;

use serde_json::Value;

use crate::support::{Folder, assert_sentence};

const RENDER: [&str; 10] =
    ["render", "scene.xml", "--quiet", "--spp", "12", "--spp-per-step", "4", "--steps", "even", "--profile"];

fn profile(folder: &Folder, arguments: &[&str]) -> (Value, String) {
    let output: Output = folder.run(&[&RENDER[..], &["profile.json"], arguments].concat());
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    (folder.read_json("profile.json"), String::from_utf8(output.stdout).unwrap())
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} is {}", value[name]))
}

fn slices(trace: &Value, track: u32) -> Vec<&Value> {
    let events = trace["traceEvents"].as_array().unwrap().iter();
    events.filter(|event| event["ph"] == "X" && event["tid"] == track).collect()
}

fn end(slice: &Value) -> f64 {
    number(slice, "ts") + number(slice, "dur")
}

#[test]
fn every_dispatch_is_timed() {
    let folder = Folder::new();
    let (trace, table) = profile(&folder, &["--stats", "stats.json"]);
    let stats = folder.read_json("stats.json");
    let summary = &trace["otherData"];
    let kernels = summary["kernels"].as_array().unwrap();
    let names: Vec<_> = kernels.iter().map(|kernel| kernel["kernel"].as_str().unwrap()).collect();
    for name in ["trace", "update_radiance", "update_normalization"] {
        assert!(names.iter().any(|found| found.contains(name)) && table.contains(name), "{name}: {table}");
    }
    let busy: f64 = kernels.iter().map(|kernel| number(kernel, "milliseconds")).sum();
    let shares: f64 = kernels.iter().map(|kernel| number(kernel, "share")).sum();
    let (wall, other) = (number(summary, "milliseconds"), number(summary, "other_milliseconds"));
    assert!(busy > 0.0 && (busy + other) / wall < 1.001 && (shares - busy / wall).abs() < 1e-9, "{summary}");
    assert_eq!(summary["rays"], stats["totals"]["rays"]);
    assert!((wall / 1e3 / number(&stats["totals"], "seconds") - 1.0).abs() < 1e-6);
    assert_eq!(summary["steps"].as_array().unwrap().len(), 3);
}

#[test]
fn the_trace_nests() {
    let folder = Folder::new();
    let (trace, _) = profile(&folder, &[]);
    let (steps, submissions, kernels) = (slices(&trace, 1), slices(&trace, 2), slices(&trace, 3));
    assert_eq!(steps.len(), 3);
    assert!(kernels.len() >= 9 && submissions.len() >= 6, "{} and {}", kernels.len(), submissions.len());
    // The device's clock may run a little faster than the host's.
    let slack = |slice: &Value| 1000.0 + 0.01 * number(slice, "dur");
    for kernel in &kernels {
        let within =
            |outer: &&Value| number(outer, "ts") <= number(kernel, "ts") && end(kernel) <= end(outer) + slack(kernel);
        assert!(steps.iter().any(within), "no step holds {kernel}");
        assert!(submissions.iter().any(within), "no submission holds {kernel}");
    }
    assert!(kernels.windows(2).all(|pair| number(pair[0], "ts") <= number(pair[1], "ts")));
    let named = trace["traceEvents"].as_array().unwrap().iter().filter(|event| event["name"] == "thread_name").count();
    assert_eq!(named, 3);
}

#[test]
fn a_plain_path_tracer_updates_nothing() {
    let folder = Folder::new();
    let (trace, table) = profile(&folder, &["--sampler", "bsdf"]);
    assert_eq!(trace["otherData"]["kernels"].as_array().unwrap().len(), 1, "{table}");
    assert!(!table.contains("update_radiance"), "{table}");
}

#[test]
fn timing_changes_no_pixel() {
    let folder = Folder::new();
    profile(&folder, &["-o", "timed.exr"]);
    folder.render(&["--spp", "12", "--spp-per-step", "4", "--steps", "even", "-o", "plain.exr"]);
    let read = |name| lodestar::image::exr::read_rgb(&folder.path(name)).unwrap();
    assert_eq!(read("timed.exr"), read("plain.exr"));
}

#[test]
fn what_cannot_be_written_is_known_at_once() {
    let folder = Folder::new();
    let before = folder.names();
    assert_sentence(&folder.run(&[&RENDER[..], &["missing/profile.json"]].concat()), 1, &["missing/profile.json"]);
    assert_eq!(folder.names(), before);
}
