//! Programs in `examples/` do what they promise. Cargo builds them beside the tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use lodestar::film;

/// Runs an example and fails unless it succeeds.
fn run(name: &str, arguments: &[&Path]) {
    let test = std::env::current_exe().unwrap();
    // The test lies in `deps`, below the folder of the profile.
    let profile = test.ancestors().nth(2).unwrap();
    let program = profile.join("examples").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    let path = program.display();
    assert!(
        program.exists(),
        "{path} is missing: `cargo build --release --examples` builds it, as does a whole `cargo test`"
    );
    let output = Command::new(&program).args(arguments).output().unwrap();
    assert!(output.status.success(), "{path}: {}", String::from_utf8_lossy(&output.stderr));
}

fn furnace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/furnace/scene.xml")
}

fn mean(picture: &lodestar::Picture) -> f32 {
    picture.rgb().iter().flatten().sum::<f32>() / (3 * picture.rgb().len()) as f32
}

#[test]
fn a_file_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    run("render_file", &[&furnace(), &out]);
    let (picture, _) = film::read_picture(&out).unwrap();
    assert_eq!((picture.width, picture.height), (64, 64));
    assert!(picture.sample_count.iter().all(|&count| count == 64));
    // Radiance 1 comes from all sides and meets an albedo of 0.5. The background is black or 1.
    assert!(mean(&picture) > 0.1, "{}", mean(&picture));
    // The library renders equal bits.
    let options = lodestar::Options::new().samples(64).size(64, 64);
    let again = lodestar::render(furnace(), &options).unwrap();
    assert_eq!(again.rgb(), picture.rgb());
}

#[test]
fn steps_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    run("step_by_step", &[&furnace(), folder.path()]);
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let pictures = ["16.png", "32.png", "48.png", "64.png"].map(read);
    assert!(pictures.iter().all(|bytes| bytes.starts_with(b"\x89PNG")));
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn a_scene_is_made_in_code() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    run("scene_in_code", &[&out]);
    let (picture, _) = film::read_picture(&out).unwrap();
    assert_eq!((picture.width, picture.height), (64, 48));
    assert!(picture.sample_count.iter().all(|&count| count == 32));
    let at = |x: usize, y: usize| picture.rgb()[64 * y + x];
    let [red, green, _] = at(42, 16);
    assert!(red > 3.0 * green && red > 0.1, "the sphere is red and lit: {:?}", at(42, 16));
    let [red, green, blue] = at(32, 44);
    assert!(red > 0.2 && (red - blue).abs() < 0.5 * red && green > 0.2, "the floor is gray and lit: {:?}", at(32, 44));
    let sky = at(1, 1).into_iter().zip([0.1, 0.15, 0.2]);
    assert!(sky.into_iter().all(|(found, sky)| (found - sky).abs() < 1.0e-5), "the sky: {:?}", at(1, 1));
}

/// A request for 16 samples is five steps of the schedule, so the guide learns within it.
#[test]
fn a_step_of_many_samples_is_guided() {
    let options = || lodestar::Options::new().size(32, 32).seed(5);
    let mut session = lodestar::Session::open(furnace(), &options()).unwrap();
    let progress = session.step(16).unwrap();
    assert_eq!(progress.samples, 16);
    let (mut whole, mut steps) = (lodestar::Session::open(furnace(), &options().samples(16)).unwrap(), 0);
    whole
        .run(|_| {
            steps += 1;
            std::ops::ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(steps, 5);
    assert_eq!(session.picture().unwrap().rgb(), whole.picture().unwrap().rgb());
}

/// A callback's `Break` ends the render after the step that it was called for.
#[test]
fn a_callback_ends_a_render() {
    let options = lodestar::Options::new().size(32, 32).samples(64);
    let mut session = lodestar::Session::open(furnace(), &options).unwrap();
    let end = |session: &lodestar::Session| match session.progress().samples {
        0..4 => std::ops::ControlFlow::Continue(()),
        _ => std::ops::ControlFlow::Break(()),
    };
    session.run(end).unwrap();
    assert!(session.picture().unwrap().sample_count.iter().all(|&count| count == 4));
}
