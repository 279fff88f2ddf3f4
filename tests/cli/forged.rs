//! Checkpoints of others: their hashes are right, but what they hold was made to do harm.

use std::fs;
use std::path::Path;

use lodestar::film::read_picture;
use lodestar::session::checkpoint::Checkpoint;
use serde_json::{Value, json};
use support::tier;
use xxhash_rust::xxh3::xxh3_128;

use crate::support::{Folder, assert_quiet_success, assert_sentence};

/// Bytes before the header: a magic number, the header's length and its hash.
const PREFIX_BYTES: usize = 32;

/// Changes the header of a checkpoint, and makes its hash right again.
fn forge(path: &Path, change: impl FnOnce(&mut Value)) {
    let bytes = fs::read(path).unwrap();
    let length = u64::from_le_bytes(bytes[8..16].try_into().unwrap()) as usize;
    let (header, parts) = bytes[PREFIX_BYTES..].split_at(length);
    let mut header: Value = serde_json::from_slice(header).unwrap();
    change(&mut header);
    let header = serde_json::to_vec(&header).unwrap();
    let length = (header.len() as u64).to_le_bytes();
    fs::write(path, [&bytes[..8], &length, &xxh3_128(&header).to_le_bytes(), &header, parts].concat()).unwrap();
}

/// Lets a checkpoint name these pictures.
fn name_pictures(path: &Path, names: &[&Path]) {
    forge(path, |header| header["record"]["outputs"]["paths"] = json!(names));
}

/// Folder with the folders `own`, with a checkpoint in it, and `other`.
fn with_checkpoint() -> Folder {
    let folder = Folder::new();
    for name in ["own", "own/inner", "other"] {
        fs::create_dir(folder.path(name)).unwrap();
    }
    folder.render(&["--spp", "8", "--checkpoint", "own/a.ckpt", "-o", "own/a.exr"]);
    folder
}

/// Resumes the checkpoint in the folder `at`.
fn resume(folder: &Folder, at: &str, more: &[&str]) -> std::process::Output {
    let checkpoint = folder.path("own/a.ckpt");
    let mut command = folder.command(&["resume", checkpoint.to_str().unwrap(), "--quiet", "--spp", "16"]);
    command.args(more).current_dir(folder.path(at)).output().unwrap()
}

#[test]
fn only_pictures_are_written() {
    let folder = with_checkpoint();
    folder.write("own/notes.txt", "notes");
    std::os::unix::fs::symlink("notes.txt", folder.path("own/link.exr")).unwrap();
    for name in ["own/notes.txt", "own/.bashrc", "own/link.exr"] {
        name_pictures(&folder.path("own/a.ckpt"), &[&folder.path(name)]);
        assert_sentence(
            &resume(&folder, "own", &[]),
            1,
            &["a.ckpt: its picture is ", "ends in .exr, .png, .jpg, .tif or .hdr", "-o"],
        );
    }
    assert_eq!(fs::read_to_string(folder.path("own/notes.txt")).unwrap(), "notes");
    assert!(!folder.path("own/.bashrc").exists());
}

#[test]
fn pictures_elsewhere_need_a_name_or_their_folder() {
    let folder = with_checkpoint();
    let checkpoint = folder.path("own/a.ckpt");
    folder.write("other/holiday.png", "holiday");
    std::os::unix::fs::symlink(folder.path("other"), folder.path("own/links")).unwrap();
    std::os::unix::fs::symlink(folder.path("other/holiday.png"), folder.path("own/link.png")).unwrap();
    for name in ["other/holiday.png", "own/inner/../../other/holiday.png", "own/links/holiday.png", "own/link.png"] {
        name_pictures(&checkpoint, &[&folder.path("own/a.exr"), &folder.path(name)]);
        let output = resume(&folder, "own", &[]);
        assert_sentence(
            &output,
            1,
            &["other/holiday.png", "outside of the checkpoint's folder and the current one", "-o"],
        );
        assert_eq!(fs::read_to_string(folder.path("other/holiday.png")).unwrap(), "holiday", "{name}");
    }
    // One option more goes on, and so does the folder of the picture.
    assert_quiet_success(&resume(&folder, "own", &["-o", folder.path("other/b.exr").to_str().unwrap()]));
    assert!(folder.path("other/b.exr").exists());
    name_pictures(&checkpoint, &[&folder.path("other/c.exr")]);
    assert_quiet_success(&resume(&folder, "other", &[]));
    name_pictures(&checkpoint, &[&folder.path("own/inner/d.exr")]);
    assert_quiet_success(&resume(&folder, "own", &[]));
    // The whole folder is below this one.
    name_pictures(&checkpoint, &[&folder.path("other/e.exr")]);
    assert_quiet_success(&resume(&folder, ".", &[]));
    for name in ["other/c.exr", "own/inner/d.exr", "other/e.exr"] {
        read_picture(&folder.path(name)).unwrap();
    }
}

/// Random number by SplitMix64 (Steele, Lea and Flood 2014).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Film and guide of a forged checkpoint hold anything. A render that goes on from them ends with a picture or a sentence, and so
/// does one that begins with their guide.
#[test]
fn forged_states_do_no_harm() {
    let folder = Folder::new();
    let kinds: [&[&str]; 4] =
        [&[], &["--sampler", "sphere-inversion"], &["--noise", "0.001"], &["--sample-offset", "0"]];
    let mut state = 0x5eed;
    let rounds = if tier::is_full() { 100 } else { 1 };
    for kind in kinds {
        let render = ["render", "scene.xml", "--quiet", "--spp", "16", "--checkpoint", "whole.ckpt", "-o", "a.exr"];
        assert_quiet_success(&folder.run(&[&render[..], kind].concat()));
        let whole = Checkpoint::read(&folder.path("whole.ckpt")).unwrap();
        fs::remove_file(folder.path("whole.ckpt")).unwrap();
        for _ in 0..rounds {
            let mut forged = whole.clone();
            for part in &mut forged.state.parts {
                // Some words of a part, or all of them, are anything, all ones, or infinite.
                let share = [1, 16, 256][random(&mut state) as usize % 3];
                for word in part.bytes.chunks_exact_mut(4) {
                    if random(&mut state).is_multiple_of(share) {
                        let word_of = [random(&mut state) as u32, u32::MAX, 0x7f80_0000, 0];
                        word.copy_from_slice(&word_of[random(&mut state) as usize % 4].to_le_bytes());
                    }
                }
            }
            forged.state.samples_done = [16, 1, 7, 1000][random(&mut state) as usize % 4];
            forged.write(&folder.path("a.ckpt")).unwrap();
            let begin =
                ["render", "scene.xml", "--quiet", "--spp", "8", "--seed", "9", "--guide", "a.ckpt", "-o", "b.exr"];
            for arguments in
                [&["resume", "a.ckpt", "--quiet", "--spp", "1016", "--time", "2", "-o", "a.exr"][..], &begin]
            {
                let output = folder.run(arguments);
                let said = String::from_utf8_lossy(&output.stderr);
                assert!(matches!(output.status.code(), Some(0 | 1)), "{kind:?}: {said}");
                assert!(said.lines().count() <= 3 && !said.contains("panicked"), "{kind:?}: {said}");
            }
        }
    }
}

/// Parts of a forged state are longer, shorter or others than the render needs.
/// A state whose parts repeat a name could be as long as its author likes, however long one part may be.
#[test]
fn parts_of_one_name_are_refused() {
    let folder = with_checkpoint();
    let path = folder.path("own/a.ckpt");
    forge(&path, |header| {
        let empty = json!({"name": "film", "bytes": 0, "hash": format!("{:032x}", xxh3_128(b""))});
        let parts = header["parts"].as_array_mut().unwrap();
        parts.extend([empty.clone(), empty]);
    });
    assert_sentence(&resume(&folder, "own", &[]), 1, &["a.ckpt: it has two parts of one name"]);
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let folder = with_checkpoint();
    let path = folder.path("own/a.ckpt");
    let whole = Checkpoint::read(&path).unwrap();
    let parts = whole.state.parts.iter().enumerate().filter(|(_, part)| part.bytes.len() >= 16);
    let places: Vec<_> = parts.map(|(at, _)| at).collect();
    for &at in tier::some_of(&places, 2) {
        let mut longer = whole.clone();
        longer.state.parts[at].bytes.extend([0; 64]);
        let mut shorter = whole.clone();
        let half = whole.state.parts[at].bytes.len() / 2;
        shorter.state.parts[at].bytes.truncate(half);
        let mut fewer = whole.clone();
        fewer.state.parts.remove(at);
        for forged in [longer, shorter, fewer] {
            forged.write(&path).unwrap();
            let output = resume(&folder, "own", &[]);
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(said.contains("its state has ") || said.contains("bytes per pixel"), "{said}");
            assert_sentence(&output, 1, &["a.ckpt: "]);
            let guide = ["render", "scene.xml", "--quiet", "--seed", "9", "--guide", "own/a.ckpt", "-o", "b.exr"];
            // Another size has other cells, which take what the nearest cells have.
            let sizes: [&[&str]; 2] = [&[], &["--width", "400", "--height", "300", "--spp", "1"]];
            for &size in tier::some_of(&sizes, 1) {
                let output = folder.run(&[&guide[..], size].concat());
                let said = String::from_utf8_lossy(&output.stderr);
                assert!(matches!(output.status.code(), Some(0 | 1)) && said.lines().count() <= 1, "{said}");
            }
        }
    }
}
