//! Device loss and lack of device memory, at any Vulkan call that can report them. No file is lost, and no more work
//! than since the last checkpoint. `LODESTAR_FAULT` makes calls fail on purpose (`src/gpu/fault_injection.rs`).

use std::fs;
use std::process::Output;

use lodestar::film::read_picture;
use support::tier;

use crate::resume::{assert_same_picture, samples_in};
use crate::support::{Folder, assert_quiet_success, assert_sentence};

const SPP: u32 = 64;
const PICTURE: [&str; 6] = ["--width", "40", "--height", "24", "--seed", "3"];
/// Upper bound of the number of successive calls whose failure the program survives.
const FORGIVEN: u32 = 256;
const LAST_GOOD: &str = "the last good step is number ";

fn render_with(folder: &Folder, fault: &str) -> Output {
    let begin = ["render", "scene.xml", "--quiet", "--spp", &SPP.to_string(), "-o", "a.exr"];
    let keep = ["--checkpoint", "a.ckpt", "--checkpoint-every", "0.000001"];
    folder.command(&[&begin[..], &keep, &PICTURE].concat()).env("LODESTAR_FAULT", fault).output().unwrap()
}

/// Folder with a picture of an earlier render.
fn with_old_picture() -> Folder {
    let folder = Folder::new();
    folder.write("a.exr", "earlier");
    folder
}

/// Approximate number of calls of a render: the last call whose failure ended it.
fn call_count(kind: &str) -> u32 {
    // Each look is a render of its own, so the quick tier looks less often. One submission makes eight calls that can
    // run out of memory. An odd stride meets each of them in turn.
    let stride = (if tier::is_full() { FORGIVEN / 8 } else { FORGIVEN / 2 }) - 1;
    let ends = |at: u32| !render_with(&with_old_picture(), &format!("{kind}@{at}")).status.success();
    let (mut last, mut at) = (1, 1);
    while at < last + FORGIVEN {
        if ends(at) {
            last = at;
        }
        at += stride;
    }
    last
}

/// Number of samples that were complete before the fault, from the program's message.
fn whole_samples(message: &str) -> u32 {
    let rest = message.split(LAST_GOOD).nth(1).and_then(|rest| rest.split("ended at ").nth(1));
    rest.map_or(0, |rest| rest.split(' ').next().unwrap().parse().unwrap())
}

/// Checks the files after one fault. Returns the message, or `None` if the program survived the fault.
fn message_of(fault: &str, output: &Output, folder: &Folder) -> Option<String> {
    let message = String::from_utf8(output.stderr.clone()).unwrap();
    let strangers = |name: &String| !["a.ckpt", "a.exr", "scene.xml"].contains(&&name[..]);
    assert_eq!(folder.names().into_iter().filter(strangers).collect::<Vec<_>>(), [""; 0], "{fault}: {message}");
    if output.status.success() {
        assert_eq!(samples_in(&folder.path("a.ckpt")), SPP, "{fault}");
        return None;
    }
    assert_eq!(output.status.code(), Some(1), "{fault}: {message}");
    assert!(message.starts_with("lodestar: error: ") && message.lines().count() == 1, "{fault}: {message}");
    let word = if fault.starts_with("lost") { "the device was lost" } else { "out of device memory" };
    assert!(message.contains(word), "{fault}: {message}");
    let whole = whole_samples(&message);
    if whole == 0 {
        // After lack of memory, the device still has the result of the first step.
        let is_old = fs::read(folder.path("a.exr")).unwrap() == b"earlier";
        let is_new = || fault.starts_with("memory") && read_picture(&folder.path("a.exr")).is_ok();
        assert!(is_old || is_new(), "{fault}: {message}");
        return Some(message);
    }
    assert!(
        ["trace, samples", "wave_", "update_", "pool_", "blend_"].iter().any(|kernel| message.contains(kernel)),
        "{fault}: {message}"
    );
    assert_eq!(samples_in(&folder.path("a.ckpt")), whole, "{fault}: {message}");
    let picture = read_picture(&folder.path("a.exr")).unwrap().0;
    assert!(picture.radiance.iter().flatten().all(|value| value.is_finite()), "{fault}");
    assert!(picture.sample_count.iter().all(|&count| count > 0), "{fault}: {message}");
    Some(message)
}

/// A fault of the device loses the last interval at most, and no file. The quick tier has a few lost devices.
#[test]
fn faults_lose_the_last_interval_at_most_and_no_file() {
    let is_full = tier::is_full();
    let per_kind = if is_full { 60 } else { 4 };
    let whole = Folder::new();
    whole.render(&[&["--spp", &SPP.to_string(), "-o", "whole.exr"][..], &PICTURE].concat());
    for &kind in tier::some_of(&["lost", "memory"], 1) {
        let calls = call_count(kind);
        let (mut messages, mut late) = (Vec::new(), 0);
        let stride = (calls / per_kind) | 1;
        for place in 0..per_kind {
            let at = 1 + place * stride;
            let (fault, folder) = (format!("{kind}@{at}"), with_old_picture());
            let output = render_with(&folder, &fault);
            let Some(message) = message_of(&fault, &output, &folder) else { continue };
            println!("{fault} of about {calls}: {message}");
            if whole_samples(&message) > 0 {
                late += 1;
                if is_full || late == 1 {
                    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--quiet"]));
                    assert_same_picture(&folder.path("a.exr"), &whole.path("whole.exr"));
                }
            }
            messages.push(message);
        }
        // The program survives many faults, such as those in naming objects for debuggers.
        assert!(messages.len() as u32 >= per_kind.div_ceil(5) && late > 0, "{kind}: {messages:?}");
    }
}

/// Lack of memory gives a message: what needs memory, how much, and how to need less. The first buffers are allocated by
/// one of the early calls. Which one it is changes from run to run, because threads make calls side by side. The test
/// therefore tries each early call several times.
#[test]
fn out_of_memory_says_what_needs_how_much_and_what_makes_it_less() {
    let told = (0..4).flat_map(|_| 1..80).find_map(|at| {
        let message = String::from_utf8(render_with(&Folder::new(), &format!("memory@{at}")).stderr).unwrap();
        message.contains("allocating").then_some(message)
    });
    let message = told.expect("an allocation");
    // The buffer holds 40 x 24 pixels of 64 bytes.
    for word in ["the film 61 kB (", "--crop", "the BVH ", "triangles", "textures and lights ", "the grids ", "--grid"]
    {
        assert!(message.contains(word), "{message} lacks {word}");
    }
}

/// Lack of memory is reported by `inspect`, too. It makes calls that a render does not make.
#[test]
fn out_of_memory_while_a_kernel_is_examined_is_said() {
    let folder = Folder::new();
    let inspect = |at: u32| {
        let mut command = folder.command(&["inspect", "update_radiance", "--device", "0", "--json"]);
        command.env("LODESTAR_FAULT", format!("memory@{at}")).output().unwrap()
    };
    let (mut at, mut failures, mut in_a_row) = (1, 0, 0);
    while in_a_row < 8 {
        let output = inspect(at);
        let is_whole = output.status.success();
        if !is_whole {
            assert_sentence(&output, 1, &["out of device memory"]);
            failures += 1;
        }
        in_a_row = if is_whole { in_a_row + 1 } else { 0 };
        at += 1;
    }
    println!("{failures} of the first {at} faults end it");
    assert!(failures >= 5, "{failures}");
}
