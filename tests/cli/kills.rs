//! Killed renders lose no file, and no more work than since the last checkpoint.

use std::path::Path;
use std::time::{Duration, SystemTime};

use lodestar::film::read_picture;
use support::tier;

use crate::resume::{assert_same_picture, samples_in};
use crate::support::{Folder, assert_quiet_success, wait_until};

const SEED: u64 = 0x1357_9bdf;
/// Time between two checkpoints, in seconds.
const EVERY: f64 = 0.1;
/// Extra time for a step, for writing the file and for a busy machine, in seconds.
const SLACK: f64 = 3.0;

/// Random number by SplitMix64 (Steele, Lea and Flood 2014).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|metadata| metadata.modified()).ok()
}

/// Arguments of the one render that all kills interrupt: to begin it, then to resume it.
fn arguments(is_begun: bool) -> Vec<String> {
    let every = EVERY.to_string();
    let begin: &[&str] = match is_begun {
        false => {
            &["render", "scene.xml", "--spp", "4000000", "--width", "64", "--height", "48", "--checkpoint", "a.ckpt"]
        }
        true => &["resume", "a.ckpt"],
    };
    let rest = ["-o", "a.exr", "--write-every", &every, "--checkpoint-every", &every, "--quiet"];
    [begin, &rest].concat().into_iter().map(str::to_owned).collect()
}

#[test]
fn kills_lose_the_last_interval_at_most_and_no_file() {
    let kills = if tier::is_full() { 200 } else { 6 };
    let folder = Folder::new();
    let (picture, checkpoint) = (folder.path("a.exr"), folder.path("a.ckpt"));
    let (mut state, mut samples, mut advances) = (SEED, 0, 0);
    println!("{kills} kills, seed {SEED:#x}");
    for kill in 0..kills {
        let began = SystemTime::now();
        let arguments = arguments(checkpoint.exists());
        let running = folder.start(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        // Every other kill happens while samples are taken and files are written. The rest happen at any time, even at
        // the start.
        let is_late = kill % 2 == 1;
        if is_late {
            wait_until(|| modified(&checkpoint).filter(|&time| time > began));
        }
        std::thread::sleep(Duration::from_millis(random(&mut state) % if is_late { 500 } else { 1500 }));
        running.signal("KILL");
        let (killed, (code, said)) = (SystemTime::now(), running.wait());
        assert_eq!((code, said), (None, String::new()), "kill {kill}");

        // The lock's file locks nothing any more, and the next render removes it.
        let known = ["a.ckpt", "a.exr", "scene.xml", ".a.ckpt.lock"];
        let strangers = |name: &String| !known.contains(&&name[..]) && !name.ends_with(".part");
        assert_eq!(folder.names().into_iter().filter(strangers).collect::<Vec<_>>(), [""; 0], "kill {kill}");
        if picture.exists() {
            read_picture(&picture).unwrap();
        }
        if !checkpoint.exists() {
            assert_eq!(samples, 0, "kill {kill}: the checkpoint is gone");
            continue;
        }
        let now = samples_in(&checkpoint);
        assert!(now >= samples, "kill {kill}: {now} samples of {samples}");
        if let Some(written) = modified(&checkpoint).filter(|&time| time > began) {
            let lost = killed.duration_since(written).unwrap_or_default().as_secs_f64();
            assert!(lost <= EVERY + SLACK, "kill {kill}: {lost} s are lost");
            advances += 1;
        }
        samples = now;
    }
    println!("{samples} samples per pixel, {advances} runs got on");
    assert!(samples > 0 && advances >= kills / 2);

    let spp = (samples + 8).to_string();
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--spp", &spp, "-o", "a.exr", "--quiet"]));
    folder.render(&["--spp", &spp, "--width", "64", "--height", "48", "-o", "whole.exr"]);
    assert_same_picture(&picture, &folder.path("whole.exr"));
    assert!(!folder.path(".a.ckpt.lock").exists());
}
