//! Checkpoints, and renders that resume from them.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use lodestar::film::read_picture;
use lodestar::session::checkpoint::Checkpoint;
use serde_json::Value;

use crate::support::{Folder, SCENE, assert_quiet_success, assert_sentence, wait_until};

/// Arguments of a render whose size is not a whole number of tiles. It has enough samples for a signal to come in time.
const LARGE: [&str; 6] = ["--width", "100", "--height", "61", "--spp", "1000000"];

pub fn samples_in(checkpoint: &Path) -> u32 {
    Checkpoint::read(checkpoint).unwrap().state.samples_done
}

/// Statistics other than time and memory.
fn counts(stats: &Value) -> Value {
    let mut counts = serde_json::json!([stats["totals"], stats["steps"]]);
    let [totals, steps] = counts.as_array_mut().unwrap().as_mut_slice() else { unreachable!() };
    for object in steps.as_array_mut().unwrap().iter_mut().chain([totals]) {
        for name in ["seconds", "ms_per_sample", "peak_bytes", "peak_resident_bytes"] {
            object.as_object_mut().unwrap().remove(name);
        }
    }
    counts
}

/// Fails unless both pictures have equal bits.
#[track_caller]
pub fn assert_same_picture(a: &Path, b: &Path) {
    // The comparison is by text, because a NaN does not equal itself.
    let [a, b] = [a, b].map(|path| format!("{:?}", read_picture(path).unwrap().0));
    assert!(a == b);
}

/// Fails unless a render that gets `signal` ends with `code`, and resumes to the bits of an uninterrupted render.
fn is_resumed_after(signal: &str, code: i32, sampler: &str) {
    let folder = Folder::new();
    let what = ["--sampler", sampler, "--steps", "even", "--seed", "3"];
    let files = ["-o", "a.exr", "--stats", "a.json", "--checkpoint", "a.ckpt", "--checkpoint-every", "0.05"];
    let running = folder.start(&[&["render", "scene.xml"][..], &LARGE, &what, &files].concat());
    // The checkpoint, which a render is ahead of, must hold samples.
    let path = folder.path("a.ckpt");
    wait_until(|| (path.exists() && samples_in(&path) > 0).then_some(()));
    running.signal(signal);
    let (ended_with, said) = running.wait();
    assert_eq!(ended_with, Some(code), "{said}");
    assert_eq!(folder.names(), ["a.ckpt", "a.exr", "a.json", "scene.xml"]);

    let samples = samples_in(&path);
    assert!(samples > 0 && samples.is_multiple_of(8), "{samples}");
    let picture = read_picture(&folder.path("a.exr")).unwrap().0;
    assert!(picture.sample_count.iter().all(|&count| count >= samples), "the picture has the last step's samples too");
    // The number of samples is not a whole number of steps.
    let spp = (samples + 20).to_string();
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--spp", &spp, "--stats", "a.json", "--quiet"]));
    assert_eq!(samples_in(&path), samples + 16, "whole steps only");
    let whole = folder.render(&[&LARGE[..4], &what, &["--spp", &spp, "-o", "whole.exr"]].concat());
    assert_same_picture(&folder.path("a.exr"), &folder.path("whole.exr"));
    assert_eq!(counts(&folder.read_json("a.json")), counts(&whole));
}

#[test]
fn an_interrupted_render_is_gone_on_with_to_the_same_bits() {
    is_resumed_after("INT", 130, "rejection-mix");
    is_resumed_after("INT", 130, "bsdf");
}

#[test]
fn a_terminated_render_is_gone_on_with_to_the_same_bits() {
    is_resumed_after("TERM", 143, "rejection-mix");
}

/// A finished render can be made longer. A checkpoint has only steps that a longer render would take, too.
#[test]
fn a_finished_render_can_be_made_longer() {
    let folder = Folder::new();
    // Steps have eight samples after the first 8 samples.
    folder.render(&["--spp", "13", "--checkpoint", "a.ckpt", "-o", "a.exr"]);
    assert_eq!(samples_in(&folder.path("a.ckpt")), 8);
    folder.render(&["--spp", "13", "-o", "thirteen.exr"]);
    fs::remove_file(folder.path("a.exr")).unwrap();
    // The render has its old length and its old output file.
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--quiet"]));
    assert_same_picture(&folder.path("a.exr"), &folder.path("thirteen.exr"));
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--quiet", "--spp", "40", "-o", "b.exr"]));
    folder.render(&["--spp", "40", "-o", "forty.exr"]);
    assert_same_picture(&folder.path("b.exr"), &folder.path("forty.exr"));
    let output = folder.run(&["resume", "a.ckpt", "--spp", "39"]);
    assert_sentence(&output, 1, &["a.ckpt: ", "holds 40 samples", "--spp"]);
}

/// A resumed render keeps the traversal, unless it gets another one.
#[test]
fn the_traversal_is_kept() {
    let folder = Folder::new();
    let files = ["--checkpoint", "a.ckpt", "-o", "a.exr"];
    folder.render(&[&["--traversal", "auto", "--spp", "1"], &files[..]].concat());
    for (more, expected) in [(&[][..], "auto"), (&["--traversal", "compute"][..], "compute")] {
        let spp = if expected == "auto" { "2" } else { "3" };
        let arguments = ["resume", "a.ckpt", "--quiet", "--spp", spp, "--stats", "b.json"];
        assert_quiet_success(&folder.run(&[&arguments[..], more].concat()));
        assert_eq!(folder.read_json("b.json")["settings"]["traversal"], expected);
    }
}

#[test]
fn time_is_counted_from_where_the_checkpoint_was() {
    let folder = Folder::new();
    let stats = folder.render(&["--time", "0.5", "--checkpoint", "a.ckpt", "-o", "a.exr"]);
    let before = (stats["totals"]["spp"].as_u64().unwrap(), stats["totals"]["seconds"].as_f64().unwrap());
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--time", "0.5", "--stats", "b.json", "--quiet"]));
    let totals = &folder.read_json("b.json")["totals"];
    assert!(totals["spp"].as_u64().unwrap() > before.0 && totals["seconds"].as_f64().unwrap() >= before.1, "{totals}");
}

#[test]
fn checkpoints_are_written_as_the_render_goes() {
    let folder = Folder::new();
    let path = folder.path("a.ckpt");
    let files = ["-o", "a.exr", "--checkpoint", "a.ckpt", "--checkpoint-every", "0.05", "--quiet"];
    let running = folder.start(&[&["render", "scene.xml"][..], &LARGE, &files].concat());
    let mut samples = 0;
    for _ in 0..3 {
        samples = wait_until(|| path.exists().then(|| samples_in(&path)).filter(|&now| now > samples));
    }
    drop(running);
    assert!(samples_in(&path) >= samples);
}

/// A second signal harms no file, even if the next slice would take seconds.
#[test]
fn a_second_signal_harms_no_file() {
    let folder = Folder::new();
    folder.render(&[
        "--spp",
        "8",
        "-o",
        "a.exr",
        "--checkpoint",
        "a.ckpt",
        "--width",
        "1100",
        "--height",
        "1100",
        "--sampler",
        "bsdf",
    ]);
    let before = ["a.exr", "a.ckpt"].map(|name| fs::read(folder.path(name)).unwrap());
    let arguments = ["resume", "a.ckpt", "--spp", "4000000", "--slice-ms", "60000", "--quiet"];
    let mut running = folder.start(&arguments);
    std::thread::sleep(Duration::from_secs(4));
    running.signal("INT");
    std::thread::sleep(Duration::from_millis(800));
    let begin = Instant::now();
    if running.is_running() {
        running.signal("INT");
    }
    assert_eq!(running.wait().0, Some(130));
    println!("ended after {:?}", begin.elapsed());
    samples_in(&folder.path("a.ckpt"));
    read_picture(&folder.path("a.exr")).unwrap();
    let after = ["a.exr", "a.ckpt"].map(|name| fs::read(folder.path(name)).unwrap());
    println!("files are {}", if before == after { "as they were" } else { "newer" });
}

#[test]
fn another_scene_is_refused_with_both_hashes() {
    let folder = Folder::new();
    folder.write("triangle.obj", "v 0 0 3\nv 1 0 3\nv 0 1 3\nf 1 2 3\n");
    let shape = r#"<shape type="obj"><string name="filename" value="triangle.obj"/></shape></scene>"#;
    let scene = SCENE.replace("</scene>", shape);
    folder.write("scene.xml", &scene);
    folder.render(&["--spp", "8", "--checkpoint", "a.ckpt", "-o", "a.exr", "-D", "gray=0.25"]);
    let hash = Checkpoint::read(&folder.path("a.ckpt")).unwrap().scene.hash;
    let refused = || {
        let output = folder.run(&["resume", "a.ckpt", "--spp", "16"]);
        assert_sentence(&output, 1, &["a.ckpt: ", "scene_hash", &hash, "scene.xml"]);
    };
    folder.write("triangle.obj", "v 0 0 3\nv 1 0 3\nv 0 1.5 3\nf 1 2 3\n");
    refused();
    folder.write("triangle.obj", "v 0 0 3\nv 1 0 3\nv 0 1 3\nf 1 2 3\n");
    folder.write("scene.xml", &scene.replace("z=\"5\"", "z=\"6\""));
    refused();
    // The render also resumes if the scene file changes without effect on the picture, or moves to another folder.
    fs::create_dir(folder.path("moved")).unwrap();
    folder.write("moved/scene.xml", &scene.replace("<emitter", "<!-- the sky --> <emitter"));
    fs::rename(folder.path("triangle.obj"), folder.path("moved/triangle.obj")).unwrap();
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--spp", "16", "--scene", "moved/scene.xml", "--quiet"]));
}

#[test]
fn a_checkpoint_is_not_written_over_by_another_render() {
    let folder = Folder::new();
    let render = ["render", "scene.xml", "--quiet", "-o", "a.exr", "--checkpoint", "a.ckpt"];
    let again = |more: &[&str]| folder.run(&[&render[..], more].concat());
    assert_quiet_success(&again(&["--spp", "16"]));
    let before = fs::read(folder.path("a.ckpt")).unwrap();
    let other = again(&["--spp", "16", "--seed", "3", "--max-depth", "5", "-D", "gray=0.25"]);
    assert_sentence(&other, 1, &["max_depth (unlimited there, 5 here)", "seed (0 there, 3 here)", "scene_hash ("]);
    let moved = again(&["--spp", "16", "--sample-offset", "64"]);
    assert_sentence(&moved, 1, &["a.ckpt: ", "another render", "sample_offset (null there, 64 here)"]);
    assert_sentence(&again(&["--spp", "8"]), 1, &["a.ckpt: ", "16 samples", "--spp asks for less"]);
    let guided = |more: &[&str]| {
        let guide = ["--spp", "16", "--seed", "3", "--guide", "a.ckpt", "--checkpoint", "b.ckpt", "-o", "b.exr"];
        folder.run(&[&["render", "scene.xml", "--quiet"], &guide[..], more].concat())
    };
    assert_quiet_success(&guided(&[]));
    // The guide stands in the checkpoint, so it is not taken again.
    assert_quiet_success(&guided(&[]));
    let without = ["render", "scene.xml", "--spp", "16", "--seed", "3", "--checkpoint", "b.ckpt", "-o", "b.exr"];
    assert_sentence(&folder.run(&without), 1, &["b.ckpt: ", "samples of the guide", "0:0..16 there, none here"]);
    assert!(fs::read(folder.path("a.ckpt")).unwrap() == before);
    folder.write("a.ckpt", "notes");
    assert_sentence(&again(&["--spp", "16"]), 1, &["a.ckpt: ", "no checkpoint", "another name"]);
    assert_eq!(fs::read_to_string(folder.path("a.ckpt")).unwrap(), "notes");
}

/// A farm starts a command again that was interrupted. The command goes on, to files that it names itself.
#[test]
fn the_same_command_goes_on_with_its_checkpoint() {
    let folder = Folder::new();
    let render = ["render", "scene.xml", "--checkpoint", "a.ckpt", "-o"];
    let run = |more: &[&str]| folder.run(&[&render[..], more].concat());
    assert_quiet_success(&run(&["a.exr", "--spp", "16", "--quiet"]));
    let output = run(&["b.exr", "--spp", "40"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("a.ckpt holds 16 samples per pixel of this render"), "{said}");
    assert_eq!(samples_in(&folder.path("a.ckpt")), 40);
    folder.render(&["--spp", "40", "-o", "forty.exr"]);
    assert_same_picture(&folder.path("b.exr"), &folder.path("forty.exr"));
    folder.render(&["--spp", "16", "-o", "sixteen.exr"]);
    assert_same_picture(&folder.path("a.exr"), &folder.path("sixteen.exr"));
    // A render that is complete ends at once.
    let stats = folder.render(&["--checkpoint", "a.ckpt", "-o", "c.exr", "--spp", "40"]);
    assert_eq!(stats["totals"]["spp"], 40);
    assert_same_picture(&folder.path("c.exr"), &folder.path("forty.exr"));
}

/// Two renders that keep one checkpoint would overwrite each other's work.
#[test]
fn one_render_at_a_time_has_a_checkpoint() {
    let folder = Folder::new();
    let render = [&["render", "scene.xml", "--checkpoint", "a.ckpt", "-o", "a.exr"][..], &LARGE].concat();
    let words = ["a.ckpt: another render keeps its checkpoint in this file"];
    let mut first = folder.start(&render);
    first.wait_for_line("/1000000 spp");
    assert_sentence(&folder.run(&render), 1, &words);
    first.signal("INT");
    let (code, said) = first.wait();
    assert_eq!(code, Some(130), "{said}");

    let resume = ["resume", "a.ckpt", "--spp", "1000000", "--quiet"];
    let second = folder.start(&resume);
    wait_until(|| folder.path(".a.ckpt.lock").exists().then_some(()));
    wait_until(|| {
        let output = folder.run(&["resume", "a.ckpt", "--spp", "1000000"]);
        String::from_utf8_lossy(&output.stderr).contains(words[0]).then_some(())
    });
    second.signal("KILL");
    second.wait();
    // The lock ends with its process.
    let samples = samples_in(&folder.path("a.ckpt"));
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--quiet", "--spp", &samples.to_string()]));
    assert_eq!(folder.names(), ["a.ckpt", "a.exr", "scene.xml"]);
}

/// A program that uses the library cannot overwrite the checkpoint that a running render keeps.
#[test]
fn a_checkpoint_of_another_render_is_not_overwritten() {
    let folder = Folder::new();
    let mut session = lodestar::Session::open(folder.path("scene.xml"), &lodestar::Options::new().samples(8)).unwrap();
    session.step(8).unwrap();
    let render = [&["render", "scene.xml", "--checkpoint", "a.ckpt", "-o", "a.exr"][..], &LARGE].concat();
    let mut running = folder.start(&render);
    running.wait_for_line("/1000000 spp");
    let error = session.write_checkpoint(folder.path("a.ckpt")).unwrap_err().to_string();
    assert!(error.contains("a.ckpt: another render keeps its checkpoint in this file"), "{error}");
    running.signal("KILL");
    running.wait();
    session.write_checkpoint(folder.path("a.ckpt")).unwrap();
    assert_eq!(samples_in(&folder.path("a.ckpt")), 8);
}

/// One of several renders that begin at one moment has the checkpoint.
#[test]
fn renders_that_begin_at_once_do_not_share_a_checkpoint() {
    let folder = Folder::new();
    let names = ["a.exr", "b.exr", "c.exr"];
    let start = |name| {
        folder.start(&[&["render", "scene.xml", "--quiet", "--checkpoint", "a.ckpt", "-o", name][..], &LARGE].concat())
    };
    let mut running: Vec<_> = names.map(start).into();
    let mut said = Vec::new();
    while running.len() > 1 {
        let at = wait_until(|| running.iter_mut().position(|process| !process.is_running()));
        said.push(running.remove(at).wait());
    }
    for (code, sentence) in said {
        assert_eq!(code, Some(1));
        assert!(sentence.contains("a.ckpt: another render keeps its checkpoint"), "{sentence}");
    }
    running.remove(0).signal("KILL");
}

/// What a killed process has left beside the checkpoint goes with the next render.
#[cfg(target_os = "linux")]
#[test]
fn parts_of_killed_processes_are_removed() {
    let folder = Folder::new();
    folder.render(&["--spp", "8", "--checkpoint", "a.ckpt", "-o", "a.exr"]);
    let mut ended = std::process::Command::new("true").spawn().unwrap();
    ended.wait().unwrap();
    let id = ended.id();
    for name in ["a.ckpt", "a.exr"] {
        folder.write(&format!(".{name}.{id}-7.part"), "half of it");
    }
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--quiet", "--spp", "16"]));
    assert_eq!(folder.names(), ["a.ckpt", "a.exr", "scene.xml", "stats.json"]);
}

#[test]
fn a_damaged_checkpoint_is_one_sentence() {
    let folder = Folder::new();
    folder.render(&["--spp", "8", "--checkpoint", "a.ckpt", "-o", "a.exr"]);
    let whole = fs::read(folder.path("a.ckpt")).unwrap();
    for (at, words) in [(0, "no checkpoint"), (100, "cut short or altered"), (whole.len() - 1, "cut short or altered")]
    {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        fs::write(folder.path("a.ckpt"), &bytes).unwrap();
        assert_sentence(&folder.run(&["resume", "a.ckpt"]), 1, &["a.ckpt: ", words]);
        fs::write(folder.path("a.ckpt"), &whole[..at]).unwrap();
        assert_sentence(&folder.run(&["resume", "a.ckpt"]), 1, &["a.ckpt: "]);
    }
    assert_sentence(&folder.run(&["resume", "missing.ckpt"]), 1, &["missing.ckpt: cannot be read"]);
}
