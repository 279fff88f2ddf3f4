//! Signals such as Ctrl-C: the picture so far is written, and the exit code is 128 plus the signal's number.

use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

use lodestar::image::exr::{read_layer, read_rgb};

use crate::support::{Folder, Running, wait_until};
use crate::torture::library;

const OUTPUTS: [&str; 8] = ["render", "scene.xml", "-o", "a.exr", "-o", "b.png", "--stats", "s.json"];

/// Fails unless a render that gets `signal` `count` times writes its files and ends with `code`.
fn is_answered(signal: &str, count: u32, code: i32) {
    let folder = Folder::new();
    let size = ["--spp", "1000000", "--width", "64", "--height", "64"];
    let arguments = [&OUTPUTS[..], &size].concat();
    let mut running = match signal {
        // Whoever runs the tests may ignore this signal, as `nohup` does, and a child would ignore it, too.
        "HUP" => {
            let mut process = Command::new("env");
            process.args(["--default-signal=HUP", env!("CARGO_BIN_EXE_lodestar")]);
            folder.start_process(process.args(arguments))
        }
        _ => folder.start(&arguments),
    };
    running.wait_for_line("/1000000 spp");
    let begin = Instant::now();
    (0..count).for_each(|_| running.signal(signal));
    let (ended_with, said) = running.wait();
    assert_eq!(ended_with, Some(code), "{said}");
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    assert!(!said.contains("lodestar:"), "{said}");

    assert_eq!(folder.names(), ["a.exr", "b.png", "s.json", "scene.xml"]);
    let picture = folder.path("a.exr");
    assert!(read_rgb(&picture).unwrap().pixels.iter().flatten().all(|value| value.is_finite()));
    let samples = read_layer(&picture, "samples").unwrap().pixels;
    assert!(samples.iter().all(|pixel| pixel[0] >= 1.0));
    let totals = &folder.read_json("s.json")["totals"];
    assert_eq!(totals["paths"].as_f64().unwrap(), samples.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>());
}

#[test]
fn an_interrupt_is_answered_with_the_picture_so_far() {
    is_answered("INT", 1, 130);
}

#[test]
fn a_termination_is_answered_with_the_picture_so_far() {
    is_answered("TERM", 1, 143);
}

/// A closed terminal or connection ends a render with its picture.
#[cfg(target_os = "linux")]
#[test]
fn a_hangup_is_answered_with_the_picture_so_far() {
    is_answered("HUP", 1, 129);
}

/// `nohup` starts a program with SIGHUP ignored.
#[test]
fn a_hangup_is_ignored_under_nohup() {
    let folder = Folder::new();
    let mut process = Command::new("nohup");
    process.arg(env!("CARGO_BIN_EXE_lodestar")).args(OUTPUTS).args(["--spp", "1000000"]);
    let mut running = folder.start_process(&mut process);
    running.wait_for_line("/1000000 spp");
    running.signal("HUP");
    std::thread::sleep(Duration::from_millis(500));
    assert!(running.is_running());
    running.signal("TERM");
    assert_eq!(running.wait().0, Some(143));
    assert!(folder.path("a.exr").exists());
}

/// Two signals in short succession count as one. `timeout` sends two: one to the process and one to its group.
#[test]
fn a_signal_sent_twice_is_one() {
    is_answered("TERM", 2, 143);
}

/// Starts the program, which waits before it opens its scene until the file `release` is in the second folder. `None` where there is no C
/// compiler for the library that holds it.
fn start_held(folder: &Folder) -> Option<(Running, tempfile::TempDir)> {
    let Some(library) = library() else {
        println!("skipped: there is no C compiler `cc`");
        return None;
    };
    let outside = tempfile::tempdir().unwrap();
    // Whoever runs the tests may ignore this signal, as `nohup` does.
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP", env!("CARGO_BIN_EXE_lodestar")]);
    command.args(["render", "scene.xml", "-o", "a.exr", "--stats", "s.json"]);
    command.env("LD_PRELOAD", library).env("TORTURE_FOLDER", folder.path("").canonicalize().unwrap());
    command.env("TORTURE_DEED", "hold").env("TORTURE_RELEASE", outside.path().join("release"));
    let running = folder.start_process(command.env("TORTURE_LOG", outside.path().join("log")));
    let is_held = || fs::read_to_string(outside.path().join("log")).is_ok_and(|log| log.contains("hold"));
    wait_until(|| is_held().then_some(()));
    Some((running, outside))
}

#[cfg(target_os = "linux")]
#[test]
fn a_later_signal_ends_the_process_at_once() {
    for (second, code) in [("INT", 130), ("TERM", 143)] {
        let folder = Folder::new();
        let Some((mut running, _outside)) = start_held(&folder) else { return };
        running.signal("INT");
        std::thread::sleep(Duration::from_millis(200));
        assert!(running.is_running(), "the first one waits for the render");
        wait_until(|| {
            running.signal(second);
            (!running.is_running()).then_some(())
        });
        let (ended_with, said) = running.wait();
        assert_eq!(ended_with, Some(code));
        assert_eq!(said, "stopping at the next chance; press Ctrl-C again to end at once, without a picture\n");
        assert_eq!(folder.names(), ["scene.xml"]);
    }
}

/// A connection that ends may send the signal twice, from the shell and from the system. The process still ends by itself.
#[cfg(target_os = "linux")]
#[test]
fn a_second_hangup_ends_nothing_early() {
    let folder = Folder::new();
    let Some((mut running, outside)) = start_held(&folder) else { return };
    for _ in 0..2 {
        running.signal("HUP");
        std::thread::sleep(Duration::from_millis(800));
        assert!(running.is_running());
    }
    fs::write(outside.path().join("release"), "").unwrap();
    assert_eq!(running.wait().0, Some(129));
    assert_eq!(folder.read_json("s.json")["totals"]["paths"], 0);
}

/// No file is written before the first sample: a black picture would replace a good one.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_before_the_first_sample_leaves_earlier_pictures_alone() {
    let folder = Folder::new();
    folder.write("a.exr", "earlier");
    let Some((running, outside)) = start_held(&folder) else { return };
    running.signal("INT");
    std::thread::sleep(Duration::from_millis(100));
    fs::write(outside.path().join("release"), "").unwrap();
    let (code, said) = running.wait();
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("lodestar: warning: ") && said.contains("so no picture is written"), "{said}");
    assert_eq!(fs::read_to_string(folder.path("a.exr")).unwrap(), "earlier");
    assert_eq!(folder.read_json("s.json")["totals"]["paths"], 0);
}

/// Interrupts are answered with `--quiet`, too, as for a script that starts the program in the background.
#[test]
fn a_quiet_render_is_interrupted_just_so() {
    let folder = Folder::new();
    let arguments = [&OUTPUTS[..], &["--spp", "4000000000", "--quiet", "--write-every", "0.1"]].concat();
    let running = folder.start(&arguments);
    wait_until(|| folder.path("a.exr").exists().then_some(()));
    running.signal("INT");
    assert_eq!(running.wait(), (Some(130), String::new()));
}
