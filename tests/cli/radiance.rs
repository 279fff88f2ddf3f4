//! Subcommand `lodestar radiance`.

use glam::DVec3;
use lodestar::image::exr::read_rgb;
use lodestar::math::direction_map::bin_center;
use lodestar::settings::DirectionMap;
use support::tier;

use crate::support::{Folder, assert_sentence, attribute};

const FURNACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace/scene.xml");
const SIDE: u32 = 8;
/// Number of steps, of 8 samples per pixel each.
const STEPS: u32 = 32;

/// Radiance by bin at a point of the furnace.
fn map(folder: &Folder, more: &[&str]) -> Vec<f32> {
    let fixed = [
        "radiance",
        FURNACE,
        "--pixel",
        "20,30",
        "--sampler",
        "rejection-mix",
        "--directions",
        "8",
        "--width",
        "64",
        "--height",
        "64",
        "-o",
        "a.exr",
    ];
    let output = folder.run(&[&fixed[..], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let image = read_rgb(&folder.path("a.exr")).unwrap();
    assert_eq!((image.width, image.height), (SIDE, SIDE));
    image.pixels.iter().map(|pixel| pixel[0]).collect()
}

/// Bins that lie entirely above the surface.
fn above(folder: &Folder) -> Vec<usize> {
    let text = attribute(&folder.path("a.exr"), "surface_normal");
    let numbers: Vec<f64> = text.trim_matches(['[', ']']).split(", ").map(|number| number.parse().unwrap()).collect();
    let normal = DVec3::from_slice(&numbers);
    let height = |bin: &usize| bin_center(DirectionMap::EqualArea, *bin as u32, SIDE).dot(normal);
    (0..(SIDE * SIDE) as usize).filter(|bin| height(bin) > 0.4).collect()
}

fn mean(map: &[f32], bins: &[usize]) -> f32 {
    bins.iter().map(|&bin| map[bin]).sum::<f32>() / bins.len() as f32
}

/// Radiance that `STEPS` steps learn from targets 0.5 + 0.5 L, at rates of 1 over the decayed count of targets.
fn bootstrapped() -> f32 {
    let (mut distance, mut weight) = (1.0, 0.0);
    for _ in 0..STEPS {
        weight = weight * 0.95 + 1.0;
        distance *= 1.0 - 0.5 / weight;
    }
    1.0 - distance
}

/// The known radiance of a furnace is learned. The furnace emits 0.5 and reflects half, so n edges see 1 - 2^-n in
/// every direction. The quick tier has two learners.
#[test]
fn the_truth_of_a_furnace_is_known_and_learned() {
    let folder = Folder::new();
    let truth = map(&folder, &["--truth", "--spp", "16", "--rr-depth", "100"]);
    let bins = above(&folder);
    assert!(bins.len() > 12, "{bins:?}");
    assert!(bins.iter().all(|&bin| (truth[bin] - 1.0).abs() < 2.0e-3), "{truth:?}");
    let short = map(&folder, &["--truth", "--spp", "16", "--rr-depth", "100", "--max-depth", "2"]);
    assert!((mean(&short, &bins) - 0.75).abs() < 2.0e-3, "{short:?}");
    let learned = |learner| mean(&map(&folder, &["--learner", learner, "--spp", &(8 * STEPS).to_string()]), &bins);
    let bootstrapped = bootstrapped();
    let cases = [("sarsa", bootstrapped), ("monte-carlo", 1.0), ("expected-sarsa", bootstrapped)];
    for &(learner, expected) in tier::some_of(&cases, 2) {
        let learned = learned(learner);
        println!("{learner}: {learned}, expected {expected}");
        assert!((learned - expected).abs() < 0.03, "{learner}: {learned}, not {expected}");
    }
}

#[test]
fn what_has_no_map_is_said() {
    let folder = Folder::new();
    let refuse = |more: &[&str], words: &[&str]| {
        let output = folder.run(&[&["radiance", FURNACE, "-o", "a.exr"], more].concat());
        assert_sentence(&output, 1, words);
        assert_eq!(folder.names(), ["scene.xml"]);
    };
    refuse(&["--pixel", "64,0", "--width", "64", "--height", "64"], &["--pixel 64,0", "64 x 64"]);
    refuse(&["--pixel", "0,0", "--sampler", "bsdf"], &["--sampler bsdf learns nothing"]);
    refuse(&["--pixel", "0,0", "--nee", "on"], &["--nee on"]);
    refuse(&["--pixel", "0,0", "--steps", "growing"], &["--steps growing is for a picture"]);
    refuse(&["--pixel", "0,0", "--sample-weights", "growing"], &["--sample-weights is for a picture"]);
    refuse(
        &["--pixel", "0,0", "--decay", "0.9", "--sampler", "quadtree"],
        &["--decay is used by the samplers", "the sampler here is quadtree"],
    );
    let output = folder.run(&["radiance", "scene.xml", "--pixel", "0,0", "-o", "a.exr"]);
    assert_sentence(&output, 1, &["--pixel 0,0", "nothing to be seen"]);
    let output = folder.run(&["radiance", FURNACE, "-o", "a.exr", "--pixel", "1;2"]);
    assert_sentence(&output, 2, &["write it as X,Y"]);
}

/// A point is that of the first surface that scatters. Holes before it do not count.
#[test]
fn a_point_is_seen_through_holes() {
    let folder = Folder::new();
    let scene = |pane: &str| {
        format!(
            "<scene version='3.0.0'><sensor type='perspective'><transform name='to_world'>\
             <lookat origin='0,0,4' target='0,0,0' up='0,1,0'/></transform></sensor>{pane}\
             <shape type='rectangle'><bsdf type='diffuse'/></shape><emitter type='constant'/></scene>"
        )
    };
    let pane =
        "<shape type='rectangle'><transform name='to_world'><translate z='1'/></transform><bsdf type='null'/></shape>";
    let point = |pane: &str| {
        folder.write("pane.xml", &scene(pane));
        let output = folder.run(&[
            "radiance", "pane.xml", "--pixel", "8,8", "--width", "16", "--height", "16", "--spp", "8", "-o", "a.exr",
        ]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = attribute(&folder.path("a.exr"), "position");
        let numbers: Vec<f64> =
            text.trim_matches(['[', ']']).split(", ").map(|number| number.parse().unwrap()).collect();
        DVec3::from_slice(&numbers)
    };
    let (behind, alone) = (point(pane), point(""));
    assert!(alone.z.abs() < 1.0e-4 && behind.distance(alone) < 1.0e-4, "{behind}, not {alone}");
}
