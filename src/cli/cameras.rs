//! `lodestar render --camera all`: a picture with each camera of the scene.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lodestar::scene::{CameraChoice, LoadOptions, load, scene_file};
use lodestar::session::{Event, OutputFiles, SceneInput, Start};
use lodestar::{Error, Result};

use super::console::Console;
use super::interrupt::Interrupt;
use super::render::{RenderArgs, check_several, options, render_one};

/// Value of `--camera` that asks for all of them.
pub const ALL: &str = "all";
/// Options that belong to one picture.
const OF_ONE_PICTURE: [&str; 8] =
    ["checkpoint", "guide", "guide-out", "stats", "profile", "reference", "view", "display-server"];

/// Whether `args` ask for all cameras.
pub fn are_all_wanted(args: &RenderArgs) -> bool {
    args.given.text("camera") == Some(ALL)
}

/// Renders a scene with each of its cameras, in turn. A render that fails or is stopped ends all.
pub fn render_all(args: RenderArgs) -> Result<ExitCode> {
    let RenderArgs { scene: path, given } = args;
    check_several(&given, "--camera all", &OF_ONE_PICTURE, "name a camera")?;
    let (choices, files) = (given.load(), given.files());
    let scene = load(&scene_file(&path)?, &LoadOptions { camera: None, ..choices.clone() })?;
    let names = names(&scene.cameras);
    if names.is_empty() {
        return Err(Error::Settings(format!("{}: the scene has no camera; leave out --camera", path.display())));
    }
    let stem = scene.name.clone();
    drop(scene);
    let consoles: Vec<_> = names.iter().map(|_| Console::new(&given, given.has("output"))).collect();
    let interrupt = Interrupt::catch(consoles.iter().all(Console::is_talking))?;
    let options = options(given);
    for ((index, name), console) in names.iter().enumerate().zip(consoles) {
        if interrupt.is_raised() {
            break;
        }
        console.show(Event::Note(&format!("camera {} of {}: {name}", index + 1, names.len())));
        let camera = Some(CameraChoice::Named(index.to_string()));
        let input = SceneInput::File { path: path.clone(), options: LoadOptions { camera, ..choices.clone() } };
        let default = [PathBuf::from(format!("{stem}.exr"))];
        let pictures = if files.pictures.is_empty() { &default[..] } else { &files.pictures };
        let pictures = pictures.iter().map(|picture| named(picture, name)).collect();
        let options = options.clone().files(OutputFiles { pictures, ..files.clone() });
        let code = render_one(Start::Anew(input), &options, &console, &interrupt, None)?;
        if code != ExitCode::SUCCESS {
            return Ok(code);
        }
    }
    Ok(interrupt.exit_code())
}

/// Words for the cameras in names of files: their names, where these are words that no other camera has, or else their indices.
fn names(cameras: &[Option<String>]) -> Vec<String> {
    let is_word = |name: &&String| {
        let is_plain = name.chars().all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | ' '));
        let is_number = name.parse::<usize>().is_ok();
        !name.is_empty()
            && is_plain
            && !is_number
            && cameras.iter().flatten().filter(|other| other == name).count() == 1
    };
    let word = |(index, name): (usize, &Option<String>)| match name.as_ref().filter(is_word) {
        Some(name) => name.clone(),
        None => index.to_string(),
    };
    cameras.iter().enumerate().map(word).collect()
}

/// `out.exr` with the name `left` is `out.left.exr`.
fn named(picture: &Path, name: &str) -> PathBuf {
    let extension = picture.extension().unwrap_or_default().to_string_lossy();
    picture.with_extension(format!("{name}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_camera_has_a_file_of_its_own() {
        let cameras = ["left", "left", "a/b", "", "1", "Camera 2"].map(|name| Some(name.to_owned()));
        let words = names(&[&cameras[..], &[None]].concat());
        assert_eq!(words, ["0", "1", "2", "3", "4", "Camera 2", "6"]);
        assert_eq!(named(Path::new("a/b.c.png"), "left"), Path::new("a/b.c.left.png"));
    }
}
