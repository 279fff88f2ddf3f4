//! Statistics file of `--stats`.

use std::path::Path;

use serde_json::Value;

use crate::support::{Folder, keys};

const FILE: [&str; 10] = [
    "bvh_seconds",
    "device",
    "load_seconds",
    "pipeline_seconds",
    "scene",
    "settings",
    "setup_seconds",
    "steps",
    "totals",
    "versions",
];
const STEP: [&str; 9] = [
    "invalid_rate",
    "light_hit_rate",
    "ms_per_sample",
    "paths",
    "rays",
    "seconds",
    "shadow_rays",
    "spp",
    "tries_per_sample",
];
/// Further members of the totals.
const TOTALS: [&str; 4] = ["nonfinite_samples", "peak_bytes", "peak_resident_bytes", "primitives"];
const ERRORS: [&str; 6] = ["mae", "mae_ldr", "mean_ratio", "mse", "relmse", "relmse_trim"];

fn sorted<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names: Vec<_> = names.into_iter().collect();
    names.sort_unstable();
    names
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} is {}", value[name]))
}

fn sum(steps: &[Value], name: &str) -> f64 {
    steps.iter().map(|step| number(step, name)).sum()
}

fn check_rates(step: &Value) {
    for rate in ["invalid_rate", "light_hit_rate"] {
        assert!((0.0..1.0).contains(&number(step, rate)), "{rate}: {step}");
    }
    assert!(number(step, "rays") > number(step, "paths"), "{step}");
    let ms_per_sample = number(step, "seconds") * 1000.0 / number(step, "spp");
    assert!((number(step, "ms_per_sample") / ms_per_sample - 1.0).abs() < 1e-9, "{step}");
}

#[test]
fn steps_add_up_to_the_totals() {
    let folder = Folder::new();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.xml");
    let stats = folder.render_scene(scene.to_str().unwrap(), &["--width", "32", "--height", "32", "--spp", "20"]);
    assert_eq!(keys(&stats), FILE);
    assert_eq!(keys(&stats["totals"]), sorted(STEP.into_iter().chain(TOTALS)));
    let (totals, steps) = (&stats["totals"], stats["steps"].as_array().unwrap());
    assert_eq!(steps.iter().map(|step| number(step, "spp")).collect::<Vec<_>>(), [1.0, 1.0, 2.0, 4.0, 8.0, 4.0]);
    for step in steps {
        assert_eq!(keys(step), STEP);
        check_rates(step);
    }
    check_rates(totals);
    // A step of one sample may have no light hit at all.
    assert!(number(totals, "light_hit_rate") > 0.0);
    for name in ["spp", "paths", "rays", "shadow_rays"] {
        assert_eq!(sum(steps, name), number(totals, name), "{name}");
    }
    assert!((sum(steps, "seconds") - number(totals, "seconds")).abs() < 1e-9);
    assert_eq!(number(totals, "paths"), 20.0 * 32.0 * 32.0);
    assert_eq!((number(totals, "nonfinite_samples"), number(totals, "peak_bytes") > 65536.0), (0.0, true));
    // The first step samples the BSDF only.
    assert_eq!(number(&steps[0], "tries_per_sample"), 0.0);
    assert!(steps[1..].iter().all(|step| number(step, "tries_per_sample") >= 1.0));
    for name in ["load_seconds", "bvh_seconds", "pipeline_seconds", "setup_seconds"] {
        assert!(number(&stats, name) > 0.0, "{name}");
    }
    assert_eq!(keys(&stats["versions"]), ["driver", "lodestar", "vulkan"]);
    assert_eq!(stats["versions"]["lodestar"], env!("CARGO_PKG_VERSION"));
}

#[test]
fn errors_are_measured_on_the_way_and_at_the_end() {
    let folder = Folder::new();
    let common = ["--spp-per-step", "2", "--sampler", "bsdf"];
    folder.render(&[&common[..], &["--spp", "12", "-o", "reference.exr"]].concat());
    let measured = ["--spp", "12", "--reference", "reference.exr"];
    let stats = folder.render(&[&common[..], &measured].concat());
    let (totals, steps) = (&stats["totals"], stats["steps"].as_array().unwrap());
    assert_eq!(keys(&totals["errors"]), ERRORS);
    // The reference has the same seed, so the error vanishes.
    assert_eq!((number(&totals["errors"], "mae"), number(&totals["errors"], "mean_ratio")), (0.0, 1.0));
    let measured: Vec<_> = steps.iter().map(|step| step["errors"].is_object()).collect();
    assert_eq!(measured, [true, true, false, true, false, true]);
    assert!(number(&steps[0]["errors"], "mse") > number(&steps[3]["errors"], "mse"));
    assert_eq!(steps[5]["errors"], totals["errors"]);
}
