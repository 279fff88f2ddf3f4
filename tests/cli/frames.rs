//! `--frames`: a picture for each frame, whose guide goes from frame to frame.

use lodestar::film::read_picture;

use crate::support::{Folder, SCENE, assert_sentence, wait_until};

/// Folder with a scene that turns with the frames.
fn turning() -> Folder {
    let folder = Folder::new();
    folder.write(
        "room.xml",
        &SCENE
            .replace("value=\"0.5\"/>", "value=\"0.5\"/><default name=\"turn\" value=\"0\"/>")
            .replace("<translate", "<rotate y=\"1\" angle=\"$turn\"/><translate"),
    );
    folder
}

fn frames(folder: &Folder, seed: &str, more: &[&str]) {
    let common = ["render", "room.xml", "-D", "turn=$frame*2", "--spp", "8", "--seed", seed];
    let output = folder.run(&[&common[..], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn picture(folder: &Folder, name: &str) -> String {
    format!("{:?}", read_picture(&folder.path(name)).unwrap().0)
}

#[test]
fn each_frame_has_a_file_a_seed_and_the_guide_of_the_frame_before() {
    let folder = turning();
    frames(&folder, "40", &["--frames", "1-3", "-o", "kept.####.exr", "--guide-out", "last.guide"]);
    frames(&folder, "40", &["--frames", "1-3", "-o", "again.####.exr"]);
    frames(&folder, "40", &["--frames", "1-3", "--fresh-guide", "-o", "fresh.####.exr"]);
    for frame in ["0001", "0002", "0003"] {
        let of = |name: &str| picture(&folder, &format!("{name}.{frame}.exr"));
        assert!(of("kept") == of("again"), "{frame}");
        assert_eq!(of("kept") == of("fresh"), frame == "0001", "{frame}");
    }
    // A frame has the bits of a render with its seed and its definitions.
    let alone = ["room.xml", "-D", "turn=6", "--spp", "8", "--seed", "43", "-o", "alone.exr"];
    folder.render_scene(alone[0], &alone[1..]);
    assert!(picture(&folder, "alone.exr") == picture(&folder, "fresh.0003.exr"));
    let info = folder.run(&["info", "last.guide"]);
    assert!(String::from_utf8(info.stdout).unwrap().contains("41:0..8, 42:0..8, 43:0..8"));
}

/// A frame that begins with the guide of a key frame does not depend on the other frames of its command.
#[test]
fn any_number_of_machines_gives_the_same_bits() {
    let folder = turning();
    frames(&folder, "1000", &["--frames", "2", "-o", "key.#.exr", "--guide-out", "key.guide"]);
    let chunk = |frames_of: &str, name: &str| {
        let picture = format!("{name}.#.exr");
        frames(&folder, "40", &["--frames", frames_of, "--guide", "key.guide", "--fresh-guide", "-o", &picture]);
    };
    chunk("1-3", "one");
    chunk("2-3", "many");
    chunk("1", "many");
    for frame in 1..4 {
        let of = |name: &str| picture(&folder, &format!("{name}.{frame}.exr"));
        assert!(of("one") == of("many"), "{frame}");
    }
}

#[test]
fn scenes_are_numbered_and_frames_stay_where_a_later_one_fails() {
    let folder = Folder::new();
    for frame in ["07", "08"] {
        folder.write(&format!("room.{frame}.xml"), SCENE);
    }
    let output = folder.run(&["render", "room.##.xml", "--frames", "7-9", "--spp", "4", "--quiet"]);
    assert_sentence(&output, 1, &["error: frame 9: room.09.xml: cannot be read"]);
    assert!(folder.path("room.07.exr").exists() && folder.path("room.08.exr").exists());
}

#[test]
fn what_frames_cannot_have_is_refused() {
    let folder = turning();
    let refused = |more: &[&str], code: i32, words: &[&str]| {
        assert_sentence(&folder.run(&[&["render", "room.xml", "--quiet"], more].concat()), code, words);
    };
    let with_frames = ["--frames", "1-2", "-D", "turn=$frame"];
    let with = |more: &[&'static str]| [&with_frames[..], more].concat();
    for option in ["checkpoint", "stats", "profile", "reference", "view", "display-server"] {
        let value = if matches!(option, "view" | "display-server") { "127.0.0.1:1" } else { "a" };
        let option = format!("--{option}={value}");
        let name = option.split('=').next().unwrap();
        refused(&[&with_frames[..], &[&option]].concat(), 1, &["--frames makes several pictures", name, "is for one"]);
    }
    refused(&with(&["--camera", "all"]), 1, &["--frames and --camera all"]);
    refused(&with(&["-o", "a.exr"]), 1, &["a.exr: all frames would be written into it; write #### in its name"]);
    refused(&with(&["--seed", "4294967295"]), 1, &["frame 1 has the seed 4294967295 + 1", "smaller --seed"]);
    refused(&["--frames", "1-2"], 1, &["room.xml: each frame would be the same picture", "####", "$frame"]);
    refused(&with(&["--guide-out", "missing/last.guide"]), 1, &["missing/last.guide"]);
    assert_eq!(folder.names(), ["room.xml", "scene.xml"], "nothing is rendered before");
    refused(&["--frames", "1-2", "-D", "turn=$frame/0"], 1, &["a number follows $frame* and $frame/"]);
    refused(&["--frames", "2-1"], 2, &["--frames", "1-250"]);
    refused(&["--fresh-guide"], 2, &["--frames"]);
    let output =
        folder.command(&[&["render", "room.xml"], &with_frames[..]].concat()).env("OMPI_COMM_WORLD_SIZE", "2").output();
    assert_sentence(&output.unwrap(), 1, &["--frames", "several processes"]);
}

/// Frames whose samples a guide has learned from are told before the first one is rendered.
#[test]
fn seeds_of_the_guide_are_refused_at_once() {
    let folder = turning();
    frames(&folder, "40", &["--frames", "2", "-o", "key.#.exr", "--guide-out", "key.guide"]);
    let again = ["render", "room.xml", "-D", "turn=$frame", "--frames", "1-3", "--spp", "8", "--seed", "40", "--quiet"];
    let output = folder.run(&[&again[..], &["--guide", "key.guide"]].concat());
    assert_sentence(&output, 1, &["key.guide: the guide has learned from the seed 42, which frame 2 would have"]);
    assert!(!folder.path("room.0001.exr").exists());
}

#[test]
fn a_log_of_frames_is_json() {
    let folder = turning();
    let log = ["render", "room.xml", "-D", "turn=$frame", "--frames", "1-2", "--spp", "4", "--log", "json"];
    let output = folder.run(&log);
    let lines = String::from_utf8(output.stderr).unwrap();
    let events: Vec<serde_json::Value> = lines.lines().map(|line| serde_json::from_str(line).expect(line)).collect();
    assert_eq!(events.iter().filter(|event| event["event"] == "end").count(), 2, "{lines}");
    assert!(events.iter().any(|event| event["message"] == "frame 2, 2 of 2"), "{lines}");
}

/// Ctrl-C ends all frames. The frames so far and the guide of the last one stay.
#[test]
fn an_interrupt_ends_all_frames() {
    let folder = turning();
    let size = ["--width", "32", "--height", "32", "--spp", "64", "-o", "out.#.exr", "--guide-out", "last.guide"];
    let of_many = ["render", "room.xml", "-D", "turn=$frame*0.001", "--frames", "1-9999"];
    let running = folder.start(&[&of_many[..], &size].concat());
    wait_until(|| folder.path("out.3.exr").exists().then_some(()));
    running.signal("INT");
    let (code, said) = running.wait();
    assert_eq!(code, Some(130), "{said}");
    assert!(said.matches("stopping at the next chance").count() <= 1, "{said}");
    assert!(folder.path("last.guide").exists() && !folder.path("out.9999.exr").exists());
}
