//! `--guide` and `--guide-out`: a render begins with what another one has learned.

use lodestar::film::read_picture;
use lodestar::session::checkpoint::Checkpoint;

use crate::support::{Folder, SCENE, assert_quiet_success, assert_sentence, assert_written};

/// Folder with `guide.ckpt`: 16 samples of seed 1.
fn taught() -> Folder {
    let folder = Folder::new();
    folder.render(&["--sampler", "rejection-mix", "--spp", "16", "--seed", "1", "--checkpoint", "guide.ckpt"]);
    folder
}

const GUIDED: [&str; 6] = ["--sampler", "rejection-mix", "--spp", "8", "--guide", "guide.ckpt"];

#[test]
fn a_guide_of_other_samples_is_followed_from_the_first_sample() {
    let folder = taught();
    for others in [&["--seed", "2"][..], &["--seed", "1", "--sample-offset", "16"]] {
        folder.render(&[&GUIDED[..4], others, &["-o", "alone.exr"]].concat());
        folder.render(&[&GUIDED, others, &["-o", "guided.exr"]].concat());
        folder.render(&[&GUIDED, others, &["-o", "again.exr"]].concat());
        let picture = |name| format!("{:?}", read_picture(&folder.path(name)).unwrap().0);
        assert!(picture("alone.exr") != picture("guided.exr"), "the first step follows no guide");
        assert!(picture("again.exr") == picture("guided.exr"));
    }
}

/// The size of a picture decides how many cells its guide has.
#[test]
fn a_guide_of_a_larger_picture_is_followed() {
    let folder = Folder::new();
    let large = ["--width", "320", "--height", "240", "--spp", "8", "--seed", "1", "--checkpoint", "large.ckpt"];
    folder.render(&large);
    folder.render(&["--spp", "8", "--seed", "1", "--checkpoint", "small.ckpt"]);
    let cells = |name| {
        let parts = Checkpoint::read(&folder.path(name)).unwrap().state.parts;
        parts.iter().find(|part| part.name == "learned radiance").unwrap().bytes.len()
    };
    assert!(cells("large.ckpt") > cells("small.ckpt"), "both guides have the same cells");
    folder.render(&["--spp", "8", "--seed", "2", "-o", "alone.exr"]);
    let picture = |name| format!("{:?}", read_picture(&folder.path(name)).unwrap().0);
    for guide in ["large.ckpt", "small.ckpt"] {
        folder.render(&["--spp", "8", "--seed", "2", "--guide", guide, "-o", "guided.exr"]);
        assert!(picture("alone.exr") != picture("guided.exr"), "the first step follows no guide");
    }
}

/// Fails unless the render is refused in one sentence that has all `words`.
#[track_caller]
fn refused(folder: &Folder, arguments: &[&str], words: &[&str]) {
    let output = folder.run(&[&["render", "scene.xml", "--quiet"], arguments].concat());
    assert_sentence(&output, 1, words);
}

#[test]
fn guides_that_do_not_fit_are_refused() {
    let folder = taught();
    let guided = |more: &[&'static str]| [&GUIDED[..], more].concat();
    refused(&folder, &guided(&["--seed", "1"]), &["guide.ckpt", "--sample-offset of at least 16"]);
    let early = guided(&["--seed", "1", "--sample-offset", "8"]);
    refused(&folder, &early, &["guide.ckpt", "--sample-offset of at least 16"]);
    refused(&folder, &guided(&["--seed", "2", "-D", "gray=0.4"]), &["guide.ckpt", "another scene"]);
    refused(&folder, &guided(&["--seed", "2", "--grid", "4"]), &["guide.ckpt", "another grid"]);
    refused(&folder, &["--sampler", "bsdf", "--guide", "guide.ckpt"], &["guide.ckpt", "another sampler"]);
    refused(&folder, &["--guide", "scene.xml"], &["scene.xml", "it is no guide and no checkpoint", "--guide-out"]);
    for sampler in ["bsdf", "quadtree"] {
        let file = format!("{sampler}.ckpt");
        folder.render(&["--sampler", sampler, "--spp", "8", "--checkpoint", &file]);
        refused(&folder, &["--sampler", sampler, "--seed", "2", "--guide", &file], &[&file, "learns"]);
    }
}

/// Folder with `1.guide` and `2.guide`: 16 samples of seeds 1 and 2.
fn with_guides() -> Folder {
    let folder = Folder::new();
    for seed in ["1", "2"] {
        folder.render(&["--spp", "16", "--seed", seed, "--guide-out", &format!("{seed}.guide"), "-o", "taught.exr"]);
    }
    folder
}

/// A picture of 8 samples of seed 3, which begins with a guide.
fn guided(folder: &Folder, scene: &str, more: &[&str]) -> String {
    folder.render_scene(scene, &[&["--spp", "8", "--seed", "3", "--overwrite", "-o", "guided.exr"], more].concat());
    format!("{:?}", read_picture(&folder.path("guided.exr")).unwrap().0)
}

/// A guide lies in the world: another camera and another size take it without a warning, and the same command gives the same bits.
#[test]
fn a_guide_is_a_file_for_any_camera_and_size() {
    let folder = with_guides();
    folder.write(
        "moved.xml",
        &SCENE.replace("<film", "<transform name=\"to_world\"><rotate y=\"1\" angle=\"5\"/></transform><film"),
    );
    let large: &[&str] = &["--width", "320", "--height", "240"];
    for (scene, size) in [("scene.xml", &[][..]), ("moved.xml", &[]), ("scene.xml", large)] {
        let with_guide = || guided(&folder, scene, &[size, &["--guide", "1.guide"]].concat());
        let first = with_guide();
        assert!(first == with_guide());
        assert!(first != guided(&folder, scene, size), "the first step follows no guide");
    }
    // A checkpoint is taken for another camera, too.
    folder.render(&["--spp", "16", "--seed", "1", "--checkpoint", "a.ckpt"]);
    assert!(guided(&folder, "moved.xml", &["--guide", "a.ckpt"]) != guided(&folder, "moved.xml", &[]));
    // A checkpoint gives its guide away.
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--spp", "24", "--guide-out", "resumed.guide", "--quiet"]));
    refused(
        &folder,
        &["--seed", "1", "--guide", "resumed.guide"],
        &["resumed.guide", "--sample-offset of at least 24"],
    );
}

#[test]
fn a_guide_of_another_scene_is_taken_with_a_warning() {
    let folder = with_guides();
    let guided = |scene: &str, more: &[&str]| {
        let common = ["render", scene, "--spp", "8", "--seed", "3", "--quiet", "--guide", "1.guide", "--overwrite"];
        folder.run(&[&common[..], more].concat())
    };
    let output = guided("scene.xml", &["-D", "gray=0.25"]);
    assert!(output.status.success());
    let said = String::from_utf8_lossy(&output.stderr);
    let words = ["warning: 1.guide: its guide was learned in another scene, ", "the same bounds", "stays unbiased"];
    assert!(said.lines().count() == 1 && words.iter().all(|word| said.contains(word)), "{said}");
    folder.write("moved.xml", &SCENE.replace("z=\"5\"", "z=\"6\""));
    let output = guided("moved.xml", &[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success()
            && said.contains("bounds: [-1, -1, 4] to [1, 1, 6] there, [-1, -1, 5] to [1, 1, 7] here"),
        "{said}"
    );
}

#[test]
fn info_tells_what_a_guide_knows() {
    let folder = with_guides();
    let info = folder.run(&["info", "1.guide"]);
    let text = String::from_utf8(info.stdout).unwrap();
    for word in [
        "guide of ",
        "(hash without camera and film: ",
        "sampler: product",
        "seed:first..end: 1:0..16",
        "256 bins",
        "cells that have learned: ",
    ] {
        assert!(info.status.success() && text.contains(word), "{text}");
    }
    let json = folder.run(&["info", "1.guide", "--json"]);
    let value: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(
        (&value["scene"], &value["samples"], &value["bins"]),
        (&folder.path("").file_name().unwrap().to_str().into(), &"1:0..16".into(), &256.into())
    );
    assert!(value["learned_share"].as_f64().is_some_and(|share| 0.0 < share && share <= 1.0), "{value}");
    assert_sentence(&folder.run(&["info", "1.guide", "-D", "a=1"]), 1, &["1.guide: ", "leave -D out"]);
    folder.write("notes.guide", "notes");
    assert_sentence(&folder.run(&["info", "notes.guide"]), 1, &["notes.guide: it is no guide"]);
}

#[test]
fn guides_are_merged() {
    let folder = with_guides();
    for (parts, name) in [(["1.guide", "2.guide"], "a.guide"), (["2.guide", "1.guide"], "b.guide")] {
        assert_written(&folder.run(&[&["merge"], &parts[..], &["-o", name]].concat()), name);
    }
    let bytes = |name| std::fs::read(folder.path(name)).unwrap();
    assert!(bytes("a.guide") == bytes("b.guide") && bytes("a.guide") != bytes("1.guide"));
    let both = guided(&folder, "scene.xml", &["--guide", "a.guide"]);
    assert!(both != guided(&folder, "scene.xml", &["--guide", "1.guide"]));
    for seed in ["1", "2"] {
        refused(&folder, &["--guide", "a.guide", "--seed", seed], &["a.guide", "--sample-offset of at least 16"]);
    }
    folder.render(&["--spp", "8", "--seed", "5", "--max-depth", "4", "--nee", "off", "--guide-out", "other.guide"]);
    folder.render(&["--spp", "8", "--seed", "5", "--width", "320", "--height", "240", "--guide-out", "large.guide"]);
    folder.render(&["--spp", "8", "--seed", "5", "-D", "gray=0.25", "--guide-out", "gray.guide"]);
    let differing = [
        ("1.guide", "an earlier guide has learned from its samples 1:0..16"),
        ("other.guide", "they were learned with another "),
        ("large.guide", "they have other cells"),
        ("gray.guide", "they have learned other scenes"),
        ("scene.xml", "it is no guide"),
    ];
    for (part, word) in differing {
        let output = folder.run(&["merge", "1.guide", part, "-o", "c.guide"]);
        assert_sentence(&output, 1, &[part, word]);
    }
    assert_sentence(&folder.run(&["merge", "1.guide", "2.guide", "-o", "c.png"]), 2, &["must end in .exr or .guide"]);
}

#[test]
fn guides_that_cannot_be_written_are_refused_early() {
    let folder = Folder::new();
    for sampler in ["bsdf", "quadtree"] {
        refused(&folder, &["--sampler", sampler, "--guide-out", "a.guide"], &["--sampler", sampler, "learns"]);
    }
    refused(&folder, &["--guide-out", "missing/a.guide"], &["missing/a.guide", "cannot be written"]);
    let output = folder.run(&["render", "scene.xml", "--guide-out", "a.exr"]);
    assert_sentence(&output, 2, &["--guide-out", "the name must end in .guide"]);
    let output = folder.run(&["render", "scene.xml", "--guide-from", "a.guide"]);
    assert_sentence(&output, 2, &["'--guide-from' found; --guide sets the guide that the render begins with"]);
    assert!(!folder.path("a.guide").exists());
}

/// A setting that is given as its default stands is no other setting.
#[test]
fn a_default_that_is_given_is_no_difference() {
    let folder = Folder::new();
    folder.render(&["--spp", "16", "--seed", "1", "--checkpoint", "guide.ckpt"]);
    let same = ["--fallback", "16", "--grid", "auto", "--bsdf-share", "learned"];
    folder.render(&[&same[..], &["--spp", "8", "--guide", "guide.ckpt", "-o", "a.exr"]].concat());
    refused(&folder, &["--fallback", "3", "--guide", "guide.ckpt"], &["guide.ckpt", "another fallback"]);
}

/// A guide that has begun with another one has learned from the samples of both, also after `resume`.
#[test]
fn samples_of_earlier_guides_are_not_forgotten() {
    let folder = taught();
    folder.render(&[&GUIDED[..], &["--seed", "2", "--checkpoint", "second.ckpt"]].concat());
    assert_quiet_success(&folder.run(&["resume", "second.ckpt", "--spp", "16", "--quiet"]));
    let checkpoint = Checkpoint::read(&folder.path("second.ckpt")).unwrap();
    assert_eq!(checkpoint.record.guide_samples.to_string(), "1:0..16");
    for seed in ["1", "2"] {
        let third = ["--sampler", "rejection-mix", "--guide", "second.ckpt", "--seed", seed];
        refused(&folder, &third, &["second.ckpt", "--sample-offset of at least 16"]);
    }
}
