//! Length of a render, and its output meanwhile.

use std::fs;

use lodestar::image::exr::{read_attributes, read_layer};
use serde_json::Value;

use crate::support::{Folder, SCENE, assert_sentence, attribute, wait_until};

fn spp(stats: &Value) -> u64 {
    stats["totals"]["spp"].as_u64().unwrap()
}

fn seconds(stats: &Value) -> f64 {
    stats["totals"]["seconds"].as_f64().unwrap()
}

#[test]
fn the_samples_are_the_command_lines_else_the_scenes_else_64() {
    let folder = Folder::new();
    assert_eq!(spp(&folder.render(&["--spp", "3"])), 3);
    assert_eq!(spp(&folder.render(&[])), 12);
    let sampler = r#"<sampler type="independent"><integer name="sample_count" value="12"/></sampler>"#;
    folder.write("scene.xml", &SCENE.replace(sampler, ""));
    assert_eq!(spp(&folder.render(&[])), 64);
}

/// A time limit ends a render and not the number of samples that the scene asks for. The film is so small that its
/// samples are taken long before.
#[test]
fn time_ends_a_render() {
    let folder = Folder::new();
    let stats = folder.render(&["--time", "2", "--width", "4", "--height", "3", "--sampler", "bsdf", "-o", "a.exr"]);
    assert!(seconds(&stats) >= 2.0, "{}", seconds(&stats));
    assert!(spp(&stats) > 12, "{}", spp(&stats));
    assert!(read_layer(&folder.path("a.exr"), "samples").unwrap().pixels.iter().all(|pixel| pixel[0] > 12.0));
}

/// A step that the time limit cuts short counts its paths, although no sample is complete. The film is so large that
/// one step takes longer.
#[test]
fn a_step_that_is_cut_short_counts_what_it_did() {
    let folder = Folder::new();
    let size = ["--width", "2048", "--height", "2048", "--sampler", "bsdf"];
    let arguments = ["render", "scene.xml", "--time", "0.2", "-o", "a.exr", "--stats", "s.json", "--quiet"];
    let output = folder.run(&[&arguments[..], &size].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.lines().all(|line| line.contains("pixels are black")), "{said}");
    let stats = folder.read_json("s.json");
    let samples = read_layer(&folder.path("a.exr"), "samples").unwrap().pixels;
    let paths: f64 = samples.iter().map(|pixel| f64::from(pixel[0])).sum();
    assert_eq!(stats["totals"]["paths"].as_f64().unwrap(), paths);
    let steps = stats["steps"].as_array().unwrap();
    assert_eq!(steps.iter().map(|step| step["spp"].as_u64().unwrap()).sum::<u64>(), spp(&stats));
    assert_eq!(steps.iter().map(|step| step["paths"].as_f64().unwrap()).sum::<f64>(), paths);
    assert!(steps.iter().all(|step| step["rays"].as_u64() >= step["paths"].as_u64()));
}

/// A noise target ends a render, whatever number of samples the scene asks for.
#[test]
fn noise_ends_a_render() {
    let folder = Folder::new();
    let stats = folder.render(&["--noise", "0.1", "-o", "a.exr", "--checkpoint", "a.ckpt"]);
    let noise = &stats["totals"]["noise"];
    assert_eq!((noise["target"].as_f64(), noise["sampled_share"].as_f64()), (Some(0.1), Some(0.0)));
    assert!(noise["largest"].as_f64().unwrap() <= 0.1, "{noise}");
    let samples = read_layer(&folder.path("a.exr"), "samples").unwrap().pixels;
    let paths: f64 = samples.iter().map(|pixel| f64::from(pixel[0])).sum();
    assert_eq!(stats["totals"]["paths"].as_f64().unwrap(), paths);
    assert!(samples.iter().all(|pixel| (32.0..=spp(&stats) as f64).contains(&f64::from(pixel[0]))));
    let again = folder.run(&["resume", "a.ckpt", "-o", "b.exr", "--stats", "s.json", "--quiet"]);
    assert!(again.status.success(), "{}", String::from_utf8_lossy(&again.stderr));
    assert_eq!(spp(&folder.read_json("s.json")), spp(&stats), "nothing is left to do");
    assert_eq!(spp(&folder.render(&["--noise", "0.0001", "--spp", "40"])), 40);
}

#[test]
fn whichever_is_reached_first_ends_it() {
    let folder = Folder::new();
    for time in ["600", "1e300"] {
        let stats = folder.render(&["--time", time, "--spp", "4"]);
        assert_eq!((spp(&stats), seconds(&stats) < 60.0), (4, true));
    }
    let stats = folder.render(&["--time", "0.5", "--spp", "4000000000"]);
    assert!(seconds(&stats) < 5.0 && spp(&stats) > 0);
}

/// A time limit that ends before the first sample is an error, and an earlier picture stays.
#[test]
fn no_time_at_all_is_an_error_and_no_picture() {
    let folder = Folder::new();
    folder.write("a.exr", "earlier");
    let output = folder.run(&["render", "scene.xml", "--time", "1e-9", "-o", "a.exr", "--stats", "s.json", "--quiet"]);
    assert_sentence(&output, 1, &["before the first sample", "--time"]);
    assert_eq!(fs::read_to_string(folder.path("a.exr")).unwrap(), "earlier");
    assert_eq!(spp(&folder.read_json("s.json")), 0);
}

#[test]
fn the_picture_so_far_is_whole_and_says_what_it_is() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    let arguments = ["render", "scene.xml", "--spp", "4000000000", "--write-every", "0.05", "-o", "a.exr"];
    let mut running = folder.start(&arguments);
    wait_until(|| path.exists().then_some(()));
    let mut last = String::new();
    for _ in 0..3 {
        // A newer file may replace this one at any moment, but each is complete.
        last = wait_until(|| Some(attribute(&path, "spp")).filter(|spp| *spp != last));
        assert!(last.parse::<u32>().unwrap() > 0);
    }
    assert!(running.is_running());
    let names: Vec<_> = read_attributes(&path).unwrap().into_iter().map(|(name, _)| name).collect();
    let device = attribute(&path, "device");
    running.signal("INT");
    assert_eq!(running.wait().0, Some(130));
    assert_eq!(read_attributes(&path).unwrap().into_iter().map(|(name, _)| name).collect::<Vec<_>>(), names);
    assert_eq!(attribute(&path, "device"), device);
    assert!(device.len() > 3 && attribute(&path, "spp").parse::<u32>().unwrap() >= last.parse().unwrap());
}

/// A picture so far that cannot be written gives one warning. A disk that is full for a moment does not end the render.
#[test]
fn a_picture_so_far_that_cannot_be_written_is_one_warning() {
    let folder = Folder::new();
    fs::create_dir(folder.path("gone")).unwrap();
    let arguments = ["render", "scene.xml", "--spp", "4000000000", "--write-every", "0.05", "-o", "gone/a.exr"];
    let mut running = folder.start(&arguments);
    running.wait_for_line("spp");
    fs::remove_dir_all(folder.path("gone")).or_else(|_| fs::remove_dir_all(folder.path("gone"))).unwrap();
    running.wait_for_line("lodestar: warning: gone/a.exr: cannot be written: ");
    std::thread::sleep(std::time::Duration::from_millis(500));
    fs::create_dir(folder.path("gone")).unwrap();
    wait_until(|| folder.path("gone/a.exr").exists().then_some(()));
    running.signal("INT");
    let (code, said) = running.wait();
    assert_eq!((code, said.contains("warning")), (Some(130), false), "{said}");
}
