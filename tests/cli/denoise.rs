//! Denoising: subcommand `lodestar denoise`, and `--denoise` of `render`.
//!
//! Open Image Denoise is no part of Lodestar. Where neither `LODESTAR_OIDN` names its folder nor `setup.sh --oidn` has put it into
//! `target/oidn`, the tests that need it say so and pass.

use std::path::Path;

use lodestar::denoise::{DenoiseOptions, Denoiser, Features};
use lodestar::image::exr::{self, FileHeader};
use lodestar::image::layers::{Layers, Samples};

use crate::support::{Folder, assert_quiet_success, assert_sentence, assert_written, attribute};

/// Size of the pictures that are made here: neither side is a multiple of the other.
const WIDTH: u32 = 37;
const HEIGHT: u32 = 23;

/// Folder of the library, if it is there.
fn library() -> Option<String> {
    support::denoiser_folder().map(|folder| folder.into_os_string().into_string().unwrap())
}

fn denoiser(folder: &str) -> Denoiser {
    Denoiser::open(&DenoiseOptions { folder: Some(folder.into()), ..DenoiseOptions::default() }).unwrap()
}

/// Channels of a layer as bits, such as `["R", "G", "B"]`.
fn bits(path: &Path, names: [&str; 3]) -> Vec<u32> {
    let (layers, _) = exr::read_layers(path).unwrap();
    let channel = |name| layers.floats(name).unwrap_or_else(|| panic!("{} has no {name}", path.display())).to_vec();
    names.into_iter().flat_map(channel).map(f32::to_bits).collect()
}

const RGB: [&str; 3] = ["R", "G", "B"];
const DENOISED: [&str; 3] = ["denoised.R", "denoised.G", "denoised.B"];

/// A number from -1 to 1 for each value of a picture, by a hash.
fn noise(at: u32, channel: u32) -> f32 {
    let word = (at * 3 + channel).wrapping_mul(0x9e37_79b9);
    let word = (word ^ (word >> 15)).wrapping_mul(0x85eb_ca6b);
    (word >> 8) as f32 / 8_388_608.0 - 1.0
}

/// Colors without noise: left and right, above and below, and each channel differ, and most are brighter than 1.
fn clean(at: u32) -> [f32; 3] {
    let (x, y) = (at % WIDTH, at / WIDTH);
    let bright = if x < WIDTH / 3 { 8.0 } else { 1.0 } * if y < HEIGHT / 2 { 1.0 } else { 0.25 };
    [bright, bright / 2.0, bright / 4.0]
}

fn noisy(at: u32) -> [f32; 3] {
    let clean = clean(at);
    std::array::from_fn(|c| clean[c] * (1.0 + 0.5 * noise(at, c as u32)))
}

fn pixels(value: fn(u32) -> [f32; 3]) -> Vec<[f32; 3]> {
    (0..WIDTH * HEIGHT).map(value).collect()
}

/// Writes a picture with the channels `R`, `G`, `B` and `A`, and others.
fn write(path: &Path, color: &[[f32; 3]], kind: fn(Vec<f32>) -> Samples, others: &[(&str, f32)]) {
    let color = RGB.iter().enumerate().map(|(c, name)| (*name, color.iter().map(|pixel| pixel[c]).collect::<Vec<_>>()));
    let alpha = (0..WIDTH * HEIGHT).map(|at| if at % WIDTH < 9 { 0.0 } else { 0.5 }).collect();
    let others = others.iter().map(|(name, value)| (*name, vec![*value; (WIDTH * HEIGHT) as usize]));
    let channels = color.chain([("A", alpha)]).map(|(name, values)| (name.to_owned(), kind(values)));
    let channels = channels.chain(others.map(|(name, values)| (name.to_owned(), Samples::Floats(values))));
    let full_size = [WIDTH + 5, HEIGHT + 4];
    let layers = Layers { width: WIDTH, height: HEIGHT, offset: [3, 4], full_size, channels: channels.collect() };
    exr::write_layers(path, &layers, &FileHeader::default()).unwrap();
}

#[test]
fn without_the_library_one_sentence_says_how_to_get_it() {
    let folder = Folder::new();
    write(&folder.path("a.exr"), &pixels(noisy), Samples::Floats, &[]);
    std::fs::create_dir(folder.path("empty")).unwrap();
    for arguments in [
        &["denoise", "a.exr", "-o", "b.exr", "--oidn", "empty"] as &[&str],
        &["render", "scene.xml", "--spp", "1", "-o", "b.exr", "--denoise", "--oidn", "empty"],
    ] {
        assert_sentence(&folder.run(arguments), 1, &["--oidn names empty", "setup.sh --oidn", "LODESTAR_OIDN"]);
    }
    let mut command = folder.command(&["denoise", "a.exr", "-o", "b.exr"]);
    let output = command.env("LODESTAR_OIDN", folder.path("empty")).output().unwrap();
    assert_sentence(&output, 1, &["LODESTAR_OIDN names", "setup.sh --oidn"]);
    assert!(!folder.path("b.exr").exists());
    assert_sentence(&folder.run(&["render", "scene.xml", "--oidn", "empty"]), 2, &["--denoise", "--view"]);
    // The page denoises, too, so that its folder may be named without --denoise.
    let viewed = ["render", "scene.xml", "--quiet", "--spp", "1", "-o", "v.exr", "--view", "--oidn", "empty"];
    let output = folder.run(&viewed);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("--denoise"), "{output:?}");
}

/// The denoised picture is nearer to the truth, has the truth's brightness in each channel and place, and has no upper limit.
#[test]
fn noise_goes_and_the_picture_stays() {
    let Some(library) = library() else { return };
    let (color, clean) = (pixels(noisy), pixels(clean));
    let albedo: Vec<_> = clean.iter().map(|pixel| pixel.map(|value| value / 8.0)).collect();
    let normal: Vec<_> = (0..WIDTH * HEIGHT).map(|at| [0.0, noise(at, 7) * 0.1, -1.0]).collect();
    let denoiser = denoiser(&library);
    let features =
        Features { width: WIDTH, height: HEIGHT, color: &color, albedo: Some(&albedo), normal: Some(&normal) };
    let error = |pixels: &[[f32; 3]]| {
        let terms = pixels.as_flattened().iter().zip(clean.as_flattened()).map(|(a, b)| f64::from((a - b).abs()));
        terms.sum::<f64>() / pixels.as_flattened().len() as f64
    };
    let plain = Features { albedo: None, normal: None, ..features };
    let [guided, plain] = [features, plain].map(|features| denoiser.denoise(&features).unwrap());
    println!("errors: noisy {}, by color {}, by all layers {}", error(&color), error(&plain), error(&guided));
    assert!(error(&guided) < 0.3 * error(&color), "{} {}", error(&guided), error(&color));
    assert!(error(&plain) < 0.6 * error(&color), "{} {}", error(&plain), error(&color));
    assert_ne!(guided, plain);
    // Corners of the picture, away from the borders between its four parts.
    for (x, y) in [(3, 3), (WIDTH - 4, 3), (3, HEIGHT - 4), (WIDTH - 4, HEIGHT - 4)] {
        let at = y * WIDTH + x;
        for (value, expected) in guided[at as usize].into_iter().zip(self::clean(at)) {
            assert!((value / expected - 1.0).abs() < 0.25, "at {x},{y}: {value} is not {expected}");
        }
    }
    assert!(denoiser.device().starts_with("CPU ("), "{}", denoiser.device());
    assert!(denoiser.version().starts_with("Open Image Denoise 2."), "{}", denoiser.version());
}

/// Sizes that a tile of the library does not divide, and features that are no numbers.
#[test]
fn every_size_and_every_value_is_taken() {
    let Some(library) = library() else { return };
    let denoiser = denoiser(&library);
    for (width, height) in [(1, 1), (1, 50), (65, 3), (0, 7)] {
        let color = vec![[2.0, f32::NAN, f32::INFINITY]; (width * height) as usize];
        let features = Features { width, height, color: &color, albedo: Some(&color), normal: Some(&color) };
        let denoised = denoiser.denoise(&features).unwrap();
        assert_eq!(denoised.len(), color.len());
        assert!(denoised.as_flattened().iter().all(|value| value.is_finite()), "{width} x {height}: {denoised:?}");
    }
    let wrong = Features { width: 2, height: 2, color: &[[0.5; 3]; 3], albedo: None, normal: None };
    let error = denoiser.denoise(&wrong).unwrap_err().to_string();
    assert!(error.contains("3 pixels, not 2 x 2"), "{error}");
}

/// `render --denoise` and `denoise` make the same layer, twice, and leave all else as it was.
#[test]
fn a_render_and_its_file_are_denoised_to_the_same_bits() {
    let Some(library) = library() else { return };
    let folder = Folder::new();
    let render = |name: &str, more: &[&str]| {
        let common = ["render", "scene.xml", "--quiet", "--spp", "4", "--sample-offset", "0", "-o", name];
        assert_quiet_success(&folder.run(&[&common[..], more].concat()));
    };
    render("plain.exr", &[]);
    let denoise = ["--denoise", "--oidn", &library];
    render("a.exr", &denoise);
    render("b.exr", &denoise);
    for name in ["c.exr", "d.exr", "c.png"] {
        let mut command = folder.command(&["denoise", "plain.exr", "-o", name, "--oidn", &library, "--quiet"]);
        // The number of the library's threads changes no bit.
        let threads = if name == "c.exr" { "1" } else { "3" };
        assert_quiet_success(&command.env("OIDN_NUM_THREADS", threads).output().unwrap());
    }
    let [plain, a] = ["plain.exr", "a.exr"].map(|name| folder.path(name));
    assert_ne!(bits(&a, DENOISED), bits(&a, RGB));
    for name in ["a.exr", "b.exr", "c.exr", "d.exr"] {
        let path = folder.path(name);
        assert_eq!(bits(&path, DENOISED), bits(&a, DENOISED), "{name}");
        let (mut layers, header) = exr::read_layers(&path).unwrap();
        layers.channels.retain(|(name, _)| !name.starts_with("denoised."));
        let (expected, expected_header) = exr::read_layers(&plain).unwrap();
        assert!(layers == expected, "{name} has other channels");
        assert_eq!(header.camera_from_world, expected_header.camera_from_world);
        assert!(attribute(&path, "denoised_by").starts_with("Open Image Denoise 2."));
        assert!(attribute(&path, "denoised_on").starts_with("CPU ("));
        assert_eq!(attribute(&path, "denoised_from"), "color, albedo, normal");
    }
    assert!(image::open(folder.path("c.png")).is_ok());

    // A merged picture has no denoised layer, whether its parts have one or not.
    let second = ["--spp", "4", "--sample-offset", "4", "--quiet", "-o", "second.exr"];
    assert_quiet_success(&folder.run(&[&["render", "scene.xml"], &second[..], &denoise].concat()));
    for (first, whole) in [("plain.exr", "whole.exr"), ("a.exr", "whole-denoised.exr")] {
        assert_written(&folder.run(&["merge", first, "second.exr", "-o", whole]), whole);
        let attributes = exr::read_attributes(&folder.path(whole)).unwrap();
        assert!(!attributes.iter().any(|(name, _)| name.starts_with("denoised")), "{attributes:?}");
    }
    let [whole, whole_denoised] = ["whole.exr", "whole-denoised.exr"].map(|name| folder.path(name));
    assert!(exr::read_layers(&whole).unwrap().0 == exr::read_layers(&whole_denoised).unwrap().0);
    assert!(!exr::channel_names(&whole_denoised).unwrap().iter().any(|name| name.starts_with("denoised")));
}

/// A checkpoint has no denoised layer, and does not remember that one was asked for.
#[test]
fn a_resumed_render_is_denoised_if_it_is_asked_to_be() {
    let Some(library) = library() else { return };
    let folder = Folder::new();
    let begin = ["render", "scene.xml", "--quiet", "--spp", "2", "--checkpoint", "a.ckpt", "-o", "a.exr", "--half"];
    assert_quiet_success(&folder.run(&[&begin[..], &["--denoise", "--oidn", &library]].concat()));
    let names = || exr::channel_names(&folder.path("a.exr")).unwrap();
    assert!(names().contains(&"denoised.G".to_owned()));
    let (layers, _) = exr::read_layers(&folder.path("a.exr")).unwrap();
    let denoised = layers.channels.iter().find(|(name, _)| name == "denoised.G");
    assert!(denoised.is_some_and(|(_, samples)| matches!(samples, Samples::Halves(_))), "a layer of halves");
    assert_quiet_success(&folder.run(&["resume", "a.ckpt", "--quiet", "--spp", "3"]));
    assert!(!names().contains(&"denoised.G".to_owned()));
    let arguments = ["resume", "a.ckpt", "--quiet", "--spp", "4", "--denoise", "--oidn", &library];
    assert_quiet_success(&folder.run(&arguments));
    assert!(names().contains(&"denoised.G".to_owned()));
}

/// Name of a file, kind of its colors, its other channels, words of the warning, and the layers that were used.
type Case = (&'static str, fn(Vec<f32>) -> Samples, Vec<(&'static str, f32)>, &'static [&'static str], &'static str);

/// Pictures without albedo and normal, of half floats, with infinite depth, and with broken pixels.
#[test]
fn pictures_of_other_programs_are_denoised_as_far_as_they_go() {
    let Some(library) = library() else { return };
    let folder = Folder::new();
    let mut broken = pixels(noisy);
    broken[5] = [f32::NAN, 1.0, 1.0];
    let albedo = [("albedo.R", 0.5), ("albedo.G", 0.5), ("albedo.B", 0.5)];
    let normal = [("normal.X", 0.0), ("normal.Y", 0.0), ("normal.Z", 1.0)];
    let cases: [Case; 4] = [
        ("color", Samples::Floats, vec![], &["no layers albedo and normal"], "color"),
        (
            "half",
            Samples::Halves,
            [vec![("depth.Z", f32::INFINITY)], albedo.to_vec()].concat(),
            &["no layer normal"],
            "color, albedo",
        ),
        ("normal", Samples::Floats, normal.to_vec(), &["no layer albedo", "by color only"], "color"),
        ("broken", Samples::Floats, [albedo, normal].concat(), &["1 of 851 pixels"], "color, albedo, normal"),
    ];
    for (name, kind, others, words, from) in cases {
        let [input, output] = [format!("{name}.exr"), format!("{name}-denoised.exr")];
        let color = if name == "broken" { broken.clone() } else { pixels(noisy) };
        write(&folder.path(&input), &color, kind, &others);
        let ran = folder.run(&["denoise", &input, "-o", &output, "--oidn", &library]);
        let said = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success(), "{said}");
        let warnings: Vec<_> = said.lines().filter(|line| line.starts_with("lodestar: warning: ")).collect();
        assert_eq!(warnings.len(), 1, "{said}");
        for word in words.iter().chain([&&input[..]]) {
            assert!(warnings[0].contains(*word), "{said}");
        }
        assert!(said.trim_end().ends_with(&format!("from {from}")), "{said}");
        let [before, after] = [&input, &output].map(|name| exr::read_layers(&folder.path(name)).unwrap().0);
        assert_eq!((before.offset, before.full_size), (after.offset, after.full_size));
        assert_eq!(after.channels.len(), before.channels.len() + 3);
        for channel in &before.channels {
            // A broken value is not equal to itself.
            let text = format!("{channel:?}");
            assert!(after.channels.iter().any(|other| format!("{other:?}") == text), "{name} lost {}", channel.0);
        }
    }
    std::fs::write(folder.path("text.exr"), "no picture").unwrap();
    for (input, word) in
        [("missing.exr", "missing.exr: cannot be read"), ("text.exr", "text.exr: it is not a whole EXR")]
    {
        assert_sentence(&folder.run(&["denoise", input, "-o", "x.exr", "--oidn", &library]), 1, &[word]);
    }
}
