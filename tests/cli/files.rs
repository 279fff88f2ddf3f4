//! Pictures that a render writes.

use std::path::Path;

use lodestar::image::Image;
use lodestar::image::exr::{read_layer, read_rgb};

use crate::support::{Folder, assert_quiet_success, attribute};

fn size(image: &Image) -> (u32, u32) {
    (image.width, image.height)
}

/// Every output is written with the right content. The scene lies in another folder, and the validation layer is on.
#[test]
fn every_output_is_written_and_holds_what_it_should() {
    let folder = Folder::new();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.xml");
    let scene = scene.to_str().unwrap();
    let output = folder.run(&[
        "render",
        scene,
        "--width",
        "32",
        "--height",
        "24",
        "--spp",
        "8",
        "--seed",
        "7",
        "-o",
        "a.exr",
        "-o",
        "b.png",
        "--stats",
        "s.json",
        "--validate",
        "--quiet",
    ]);
    assert_quiet_success(&output);
    assert_eq!(folder.names(), ["a.exr", "b.png", "s.json", "scene.xml"]);

    let path = folder.path("a.exr");
    let radiance = read_rgb(&path).unwrap();
    assert_eq!(size(&radiance), (32, 24));
    assert!(radiance.pixels.iter().flatten().all(|&value| value.is_finite() && value >= 0.0));
    assert!(radiance.pixels.iter().any(|pixel| pixel[0] > 1.0), "the light is in view");
    for layer in ["variance", "samples", "albedo", "normal", "depth"] {
        assert_eq!(size(&read_layer(&path, layer).unwrap()), (32, 24), "{layer}");
    }
    assert!(read_layer(&path, "samples").unwrap().pixels.iter().all(|&pixel| pixel == [8.0; 3]));
    let depth = read_layer(&path, "depth").unwrap().pixels[12 * 32 + 16][0];
    assert!((800.0..1400.0).contains(&depth), "{depth}: the room is 800 to 1359 away");

    let stats = folder.read_json("s.json");
    for (name, value) in stats["settings"].as_object().unwrap() {
        assert_eq!(attribute(&path, name), value.as_str().map_or_else(|| value.to_string(), str::to_owned), "{name}");
    }
    let expected = [("seed", "7"), ("spp", "8"), ("version", env!("CARGO_PKG_VERSION")), ("scene", scene)];
    for (name, value) in expected.into_iter().chain([("sampler", "product"), ("width", "32")]) {
        assert_eq!(attribute(&path, name), value);
    }
    assert!(attribute(&path, "device").contains(stats["device"]["name"].as_str().unwrap()));

    let png = image::open(folder.path("b.png")).unwrap();
    assert_eq!((png.width(), png.height()), (32, 24));
}

#[test]
fn the_default_name_is_the_scenes_in_the_working_folder() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("scenes/hall")).unwrap();
    std::fs::copy(folder.path("scene.xml"), folder.path("scenes/hall/scene.xml")).unwrap();
    std::fs::copy(folder.path("scene.xml"), folder.path("scenes/wall.xml")).unwrap();
    std::fs::remove_file(folder.path("scene.xml")).unwrap();
    for scene in ["scenes/hall/scene.xml", "scenes/wall.xml"] {
        assert_quiet_success(&folder.run(&["render", scene, "--spp", "1", "--sampler", "bsdf", "--quiet"]));
    }
    assert_eq!(folder.names(), ["hall.exr", "scenes/hall/scene.xml", "scenes/wall.xml", "wall.exr"]);
}

#[test]
fn a_crop_is_that_window_of_the_film() {
    let folder = Folder::new();
    let common = ["--spp", "2", "--sampler", "bsdf"];
    folder.render(&[&common[..], &["-o", "whole.exr"]].concat());
    // The whole picture is the reference of its crop window.
    let window = ["-o", "part.exr", "--crop", "5,3,7,4", "--reference", "whole.exr"];
    let stats = folder.render(&[&common[..], &window].concat());
    let (whole, part) = (read_rgb(&folder.path("whole.exr")).unwrap(), read_rgb(&folder.path("part.exr")).unwrap());
    assert_eq!(part, whole.crop([5, 3], 7, 4).unwrap());
    assert_eq!(stats["totals"]["errors"]["mae"], 0.0);
    assert_eq!(stats["settings"]["crop"], serde_json::json!({"x": 5, "y": 3, "width": 7, "height": 4}));
}

#[test]
fn size_and_definitions_are_those_of_the_command_line() {
    let folder = Folder::new();
    let stats = folder.render(&["--spp", "8", "--scale", "0.5", "-D", "gray=0.25", "-o", "a.exr"]);
    assert_eq!((&stats["settings"]["width"], &stats["settings"]["height"]), (&8.into(), &6.into()));
    assert_eq!(size(&read_rgb(&folder.path("a.exr")).unwrap()), (8, 6));
    let albedo = read_layer(&folder.path("a.exr"), "albedo").unwrap().pixels[3 * 8 + 4];
    assert!(albedo.iter().all(|&value| (value - 0.25).abs() < 1e-6), "{albedo:?}");
}

/// Only one file is lost when its folder disappears during the render.
#[test]
fn an_output_that_fails_at_the_end_takes_no_other_with_it() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("gone")).unwrap();
    let outputs = ["-o", "gone/a.exr", "-o", "kept.exr", "-o", "gone/b.png", "-o", "kept.png", "--stats", "s.json"];
    let mut running = folder.start(&[&["render", "scene.xml", "--time", "2"][..], &outputs].concat());
    running.wait_for_line("spp");
    std::fs::remove_dir(folder.path("gone")).unwrap();
    let (code, said) = running.wait();
    let errors: Vec<_> = said.lines().filter(|line| line.starts_with("lodestar:")).collect();
    assert_eq!((code, errors.len()), (Some(1), 1), "{said}");
    assert!(errors[0].starts_with("lodestar: error: gone/a.exr: cannot be written: "), "{said}");
    assert_eq!(folder.names(), ["kept.exr", "kept.png", "s.json", "scene.xml"]);
    let samples = read_layer(&folder.path("kept.exr"), "samples").unwrap().pixels;
    let most = samples.iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
    assert_eq!(attribute(&folder.path("kept.exr"), "spp"), most.to_string());
    assert!(most >= folder.read_json("s.json")["totals"]["spp"].as_f64().unwrap() as f32);
}
