//! `--guide-from`: a render begins with what another one has learned.

use lodestar::film::read_picture;
use lodestar::session::checkpoint::Checkpoint;

use crate::support::{Folder, assert_quiet_success, assert_sentence};

/// Folder with `guide.ckpt`: 16 samples of seed 1.
fn taught() -> Folder {
    let folder = Folder::new();
    folder.render(&["--sampler", "rejection-mix", "--spp", "16", "--seed", "1", "--checkpoint", "guide.ckpt"]);
    folder
}

const GUIDED: [&str; 6] = ["--sampler", "rejection-mix", "--spp", "8", "--guide-from", "guide.ckpt"];

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
        folder.render(&["--spp", "8", "--seed", "2", "--guide-from", guide, "-o", "guided.exr"]);
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
    refused(&folder, &["--sampler", "bsdf", "--guide-from", "guide.ckpt"], &["guide.ckpt", "another sampler"]);
    refused(&folder, &["--guide-from", "scene.xml"], &["scene.xml", "no checkpoint"]);
    for sampler in ["bsdf", "quadtree"] {
        let file = format!("{sampler}.ckpt");
        folder.render(&["--sampler", sampler, "--spp", "8", "--checkpoint", &file]);
        refused(&folder, &["--sampler", sampler, "--seed", "2", "--guide-from", &file], &[&file, "learns"]);
    }
}

/// A setting that is given as its default stands is no other setting.
#[test]
fn a_default_that_is_given_is_no_difference() {
    let folder = Folder::new();
    folder.render(&["--spp", "16", "--seed", "1", "--checkpoint", "guide.ckpt"]);
    let same = ["--fallback", "16", "--grid", "auto", "--bsdf-share", "learned"];
    folder.render(&[&same[..], &["--spp", "8", "--guide-from", "guide.ckpt", "-o", "a.exr"]].concat());
    refused(&folder, &["--fallback", "3", "--guide-from", "guide.ckpt"], &["guide.ckpt", "another fallback"]);
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
        let third = ["--sampler", "rejection-mix", "--guide-from", "second.ckpt", "--seed", seed];
        refused(&folder, &third, &["second.ckpt", "--sample-offset of at least 16"]);
    }
}
