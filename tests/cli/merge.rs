//! Merged pictures, whose samples are parts of one range.

use std::fs;

use lodestar::film::Picture;
use lodestar::film::{read_picture, write_picture};

use crate::support::{Folder, assert_quiet_success, assert_sentence, assert_written, attribute};

const SIZE: [&str; 6] = ["--width", "40", "--height", "30", "--seed", "5"];

impl Folder {
    fn part(&self, name: &str, offset: u32, spp: u32, more: &[&str]) {
        let (offset, spp) = (offset.to_string(), spp.to_string());
        let range = ["--sample-offset", &offset, "--spp", &spp, "-o", name];
        self.render(&[&SIZE[..], &range, more].concat());
    }

    fn merge(&self, parts: &[&str], name: &str) -> Picture {
        assert_written(&self.run(&[&["merge"], parts, &["-o", name]].concat()), name);
        read_picture(&self.path(name)).unwrap().0
    }
}

const BSDF: [&str; 2] = ["--sampler", "bsdf"];

/// Largest relative difference of radiance, and of its standard deviation.
fn differences(a: &Picture, b: &Picture) -> [f32; 2] {
    let pairs = |a: &[[f32; 3]], b: &[[f32; 3]], least: f32| {
        let values = a.iter().flatten().zip(b.iter().flatten());
        values.map(|(a, b)| (a - b).abs() / a.abs().max(least)).fold(0.0, f32::max)
    };
    [pairs(&a.radiance, &b.radiance, 1e-3), pairs(&a.variance, &b.variance, 1e-6)]
}

/// Fails unless all numbers of both pictures have equal bits.
#[track_caller]
fn assert_same_bits(a: &Picture, b: &Picture) {
    assert!(a == b, "{:?}", differences(a, b));
}

#[test]
fn the_number_of_parts_changes_no_bit() {
    let folder = Folder::new();
    folder.part("whole.exr", 0, 64, &BSDF);
    let whole = read_picture(&folder.path("whole.exr")).unwrap().0;
    for (name, offset, spp) in
        [("a.exr", 0, 16), ("b.exr", 16, 8), ("c.exr", 24, 40), ("d.exr", 0, 24), ("e.exr", 24, 40)]
    {
        folder.part(name, offset, spp, &BSDF);
    }
    assert_same_bits(&folder.merge(&["a.exr", "b.exr", "c.exr"], "abc.exr"), &whole);
    assert_same_bits(&folder.merge(&["c.exr", "a.exr", "b.exr"], "cab.exr"), &whole);
    assert_same_bits(&folder.merge(&["d.exr", "e.exr"], "de.exr"), &whole);
    // Merging in several steps changes no bit, and neither does a part that was rendered in two runs.
    assert_same_bits(&folder.merge(&["a.exr", "c.exr"], "ac.exr"), &folder.merge(&["c.exr", "a.exr"], "ca.exr"));
    assert_same_bits(&folder.merge(&["ac.exr", "b.exr"], "acb.exr"), &whole);
    folder.part("c.exr", 24, 16, &["--sampler", "bsdf", "--checkpoint", "c.ckpt"]);
    assert_quiet_success(&folder.run(&["resume", "c.ckpt", "--spp", "40", "--quiet"]));
    assert_same_bits(&folder.merge(&["a.exr", "b.exr", "c.exr"], "abc.exr"), &whole);

    let path = folder.path("abc.exr");
    for (name, value) in [("sample_ranges", "5:0..64"), ("spp", "64"), ("seed", "5"), ("sampler", "bsdf")] {
        assert_eq!(attribute(&path, name), value);
    }
    assert_eq!(attribute(&path, "scene_hash"), attribute(&folder.path("a.exr"), "scene_hash"));
}

/// Merged parts make the picture of one render with the same samples, up to the rounding of sums.
#[test]
fn parts_make_the_picture_of_a_render_that_is_none() {
    let folder = Folder::new();
    folder.render(&[&SIZE[..], &BSDF, &["--spp", "64", "-o", "whole.exr"]].concat());
    folder.render(&[&SIZE[..], &BSDF, &["--spp", "24", "-o", "a.exr"]].concat());
    folder.part("b.exr", 24, 40, &BSDF);
    folder.part("c.exr", 0, 24, &BSDF);
    let whole = read_picture(&folder.path("whole.exr")).unwrap().0;
    let output = folder.run(&["merge", "b.exr", "a.exr", "-o", "d.exr"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.starts_with("lodestar: warning: a.exr: it carries no sums"), "{said}");
    for merged in [read_picture(&folder.path("d.exr")).unwrap().0, folder.merge(&["b.exr", "c.exr"], "e.exr")] {
        assert_eq!((&merged.sample_count, &merged.hit_count), (&whole.sample_count, &whole.hit_count));
        assert_eq!((merged.offset, merged.full_size), (whole.offset, whole.full_size));
        let [radiance, variance] = differences(&whole, &merged);
        assert!(radiance < 1e-6 && variance < 1e-4, "{radiance} {variance}");
        for (a, b) in [(whole.albedo(), merged.albedo()), (whole.normal(), merged.normal())] {
            assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-6));
        }
        assert!(whole.depth().iter().zip(merged.depth()).all(|(a, b)| a == b || (a - b).abs() < 1e-5 * a));
    }
}

/// The twin must fail: parts with other samples than the whole.
#[test]
fn other_samples_are_noticed() {
    let folder = Folder::new();
    folder.part("whole.exr", 0, 32, &BSDF);
    for (name, offset, spp) in [("a.exr", 0, 16), ("b.exr", 16, 8), ("c.exr", 40, 8)] {
        folder.part(name, offset, spp, &BSDF);
    }
    let whole = read_picture(&folder.path("whole.exr")).unwrap().0;
    let merged = folder.merge(&["a.exr", "b.exr", "c.exr"], "d.exr");
    assert!(differences(&whole, &merged)[0] > 1e-3, "c.exr has other samples");
}

/// Merged pictures can be merged again, as parts of a larger whole.
#[test]
fn merged_pictures_can_be_merged_again() {
    let folder = Folder::new();
    for (name, offset) in [("a.exr", 0), ("b.exr", 8), ("c.exr", 24)] {
        folder.part(name, offset, 8, &BSDF);
    }
    folder.merge(&["a.exr", "c.exr"], "ac.exr");
    assert_eq!(attribute(&folder.path("ac.exr"), "sample_ranges"), "5:0..8, 5:24..32");
    folder.merge(&["ac.exr", "b.exr"], "acb.exr");
    assert_eq!(attribute(&folder.path("acb.exr"), "sample_ranges"), "5:0..16, 5:24..32");
    let output = folder.run(&["merge", "ac.exr", "c.exr", "-o", "d.exr"]);
    assert_sentence(&output, 1, &["also holds samples 5:24..32"]);
}

#[test]
fn guided_parts_and_other_seeds_are_averaged() {
    let folder = Folder::new();
    folder.part("a.exr", 0, 16, &[]);
    folder.part("b.exr", 16, 48, &[]);
    let other = ["--width", "40", "--height", "30", "--seed", "6", "--spp", "16", "-o", "c.exr"];
    folder.render(&[&other[..], &["--sample-offset", "0"]].concat());
    let merged = folder.merge(&["a.exr", "b.exr", "c.exr"], "d.exr");
    assert!(merged.sample_count.iter().all(|&count| count == 80));
    assert_eq!(attribute(&folder.path("d.exr"), "sample_ranges"), "5:0..64, 6:0..16");
    assert_eq!(attribute(&folder.path("d.exr"), "seed"), "5, 6");
    let parts = ["a.exr", "b.exr", "c.exr"].map(|name| read_picture(&folder.path(name)).unwrap().0);
    for (at, merged) in merged.radiance.iter().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|part| parts[part].radiance[at][1]);
        assert!(((a * 16.0 + b * 48.0 + c * 16.0) / 80.0 - merged[1]).abs() < 1e-5);
    }
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let folder = Folder::new();
    folder.part("a.exr", 0, 8, &BSDF);
    let refused = |name: &str, words: &[&str]| {
        let output = folder.run(&["merge", "a.exr", name, "-o", "c.exr"]);
        assert_sentence(&output, 1, words);
    };
    for (more, words) in [
        (&["--width", "41"][..], "41 x 30 pixels"),
        (&["--crop", "0,0,40,29"], "40 x 29 pixels at 0,0 of 40 x 30"),
        (&["--crop", "1,0,39,30"], "39 x 30 pixels at 1,0 of 40 x 30"),
        (&["-D", "gray=0.25"], "scene_hash ("),
        (&["--max-depth", "5"], "max_depth (unlimited there, 5 here)"),
        (&["--sampler", "rejection-mix"], "sampler (bsdf there, rejection-mix here)"),
    ] {
        // The last of two values would hold, so each option is given once.
        let mut arguments = vec!["--width", "40", "--height", "30", "--sampler", "bsdf"];
        for pair in more.chunks(2) {
            match arguments.iter().position(|name| name == &pair[0]) {
                Some(at) => arguments[at + 1] = pair[1],
                None => arguments.extend(pair),
            }
        }
        arguments.extend(["--seed", "5", "--sample-offset", "8", "--spp", "8", "-o", "b.exr"]);
        folder.render(&arguments);
        refused("b.exr", &["b.exr: ", "a.exr", words]);
    }
    folder.part("b.exr", 4, 8, &BSDF);
    refused("b.exr", &["b.exr: ", "a.exr", "5:4..8"]);
    refused("a.exr", &["5:0..8"]);
    folder.write("b.exr", "no picture");
    refused("b.exr", &["b.exr: it is not a whole EXR image"]);
    let (picture, _) = read_picture(&folder.path("a.exr")).unwrap();
    write_picture(&folder.path("b.exr"), &picture, &[]).unwrap();
    refused("b.exr", &["b.exr: ", "which samples it holds"]);
    refused("missing.exr", &["missing.exr: cannot be read"]);
    assert!(!folder.path("c.exr").exists());
    let usage = folder.run(&["merge", "a.exr", "-o", "c.exr"]);
    assert_eq!(usage.status.code(), Some(2));
    fs::remove_file(folder.path("a.exr")).unwrap();
}

/// Pictures that ended by noise are refused, because a pixel's number of samples depends on their values.
#[test]
fn pictures_that_ended_by_noise_are_refused() {
    let folder = Folder::new();
    for (name, seed) in [("a.exr", "5"), ("b.exr", "6")] {
        folder.render(&["--sampler", "bsdf", "--noise", "1", "--seed", seed, "-o", name]);
    }
    let output = folder.run(&["merge", "a.exr", "b.exr", "-o", "c.exr"]);
    assert_sentence(&output, 1, &["a.exr: ", "--noise 1.0", "--spp"]);
    assert!(!folder.path("c.exr").exists());
}

#[test]
fn samples_are_numbered_in_32_bits() {
    let folder = Folder::new();
    let output = folder.run(&["render", "scene.xml", "--sample-offset", "4294967290", "--spp", "8", "-o", "a.exr"]);
    assert_sentence(&output, 1, &["--sample-offset 4294967290", "2^32"]);
    folder.render(&["--sample-offset", "4294967287", "--spp", "8", "--sampler", "bsdf", "-o", "a.exr"]);
}
