//! Environment maps of `glsl/include/light/environment.glsl`, and the delta lights of `glsl/include/light/light.glsl`.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec3, vec3};
use lodestar::encode::lights::{EnvironmentMap, EnvironmentTable};
use lodestar::scene::texture::Texels;
use lodestar::scene::{
    AreaEmitter, DeltaEmitter, DeltaKind, Environment, EnvironmentKind, Image, Primitive, PrimitiveShape, Scene,
    Textured,
};
use serde_json::Value;
use support::device::Device;
use support::statistics::{Numbers, chi_square, mean_and_error, pair_uniformity, sidak, within_four_sigma};
use support::twins::light::{delta_light, environment_coordinates, environment_radiance, pdf_environment};

use crate::lights::{LightInput, LightOutput, d3, draw, draw_from, empty_scene, parse};

const SIGNIFICANCE: f64 = 0.01;
const SAMPLES: usize = 1 << 17;

fn map_scene(width: u32, height: u32, texels: Vec<[f32; 4]>, to_world: glam::Mat3) -> Scene {
    let mut scene = empty_scene();
    scene.images.push(Image { name: "map".into(), width, height, texels: Texels::Floats(texels) });
    let kind = EnvironmentKind::Map { image: 0, scale: 1.0, to_world };
    scene.environment = Some(Environment { kind, sampling_weight: 1.0 });
    scene
}

/// Named environment maps: noise, one with a texel much brighter than the rest, and one that is mostly dark.
fn maps() -> Vec<(&'static str, u32, u32, Vec<[f32; 4]>)> {
    let mut numbers = Numbers::new(3);
    let mut noise = |count: u32| (0..count).map(|_| [(); 4].map(|()| numbers.unit() as f32)).collect::<Vec<_>>();
    let mut hot = noise(64 * 32);
    hot[10 * 64 + 63] = [5000.0, 4000.0, 3000.0, 1.0];
    let mut lone = vec![[0.0; 4]; 600 * 300];
    lone[77 * 600 + 299] = [7.0, 8.0, 9.0, 1.0];
    vec![("noise", 7, 5, noise(35)), ("hot", 64, 32, hot), ("lone", 600, 300, lone)]
}

fn turn() -> glam::Mat3 {
    glam::Mat3::from_rotation_z(0.5) * glam::Mat3::from_rotation_y(0.9)
}

/// Integral of a map's radiance, averaged over channels, by the midpoint rule.
fn flux(map: &EnvironmentMap) -> f64 {
    const ROWS: usize = 600;
    let cell = TAU / (2 * ROWS) as f64 * (PI / ROWS as f64);
    let row = |j: usize| {
        let v = (j as f64 + 0.5) / ROWS as f64;
        let sum: f64 = (0..2 * ROWS).map(|i| map.mean_rgb((i as f64 + 0.5) / (2 * ROWS) as f64, v)).sum();
        sum * (PI * v).sin()
    };
    (0..ROWS).map(row).sum::<f64>() * cell
}

/// Coordinates of the drawn directions on the map, in blocks of the table.
fn in_blocks(drawn: &[LightOutput], table: &EnvironmentTable) -> Vec<DVec2> {
    let local = turn().transpose().as_dmat3();
    let blocks = glam::dvec2(table.columns as f64, table.rows as f64);
    drawn.iter().map(|s| environment_coordinates(local * s.wi()) * blocks).collect()
}

fn fit(at: &[DVec2], table: &EnvironmentTable, factor: f64) -> f64 {
    let mut counts = vec![0; table.entries.len()];
    at.iter().for_each(|at| counts[(at.y as usize).min(table.rows - 1) * table.columns + at.x as usize] += 1);
    let expected: Vec<f64> =
        table.entries.iter().map(|e| f64::from(e.probability) * factor * at.len() as f64).collect();
    chi_square(&counts, &expected)
}

#[test]
fn directions_to_a_map_follow_their_density() {
    let level = sidak(SIGNIFICANCE, 2 * maps().len());
    for ((name, width, height, texels), seed) in maps().into_iter().zip(41..) {
        let scene = map_scene(width, height, texels, turn());
        let map = EnvironmentMap::new(&scene.images[0]);
        let table = EnvironmentTable::new(&map, 1);
        if !Device::new().has_room(name, map.texels.len() * 8 + table.entries.len() * 16, 16) {
            continue;
        }
        let drawn = draw_from(&scene, DVec3::ZERO, SAMPLES, seed);
        let at = in_blocks(&drawn, &table);
        let p = fit(&at, &table, 1.0);
        assert!(p > level && fit(&at, &table, 1.05) < level, "{name}: chi-square {p}");
        let p = pair_uniformity(at.iter().map(|at| (at.x.fract(), at.y.fract())), 16);
        assert!(p > level, "{name}: within blocks {p}");
        check_densities(name, &drawn, &map, &table);
        check_flux(name, &drawn, &map);
    }
}

fn check_densities(name: &str, drawn: &[LightOutput], map: &EnvironmentMap, table: &EnvironmentTable) {
    let local = turn().transpose().as_dmat3();
    let brightest = map.brightest_texel();
    let mut at_borders = 0;
    for s in drawn {
        assert!(s.infinite == 1 && s.delta == 0 && s.pdf > 0.0 && (s.wi().length() - 1.0).abs() < 1.0e-6);
        let twin = pdf_environment(table, local * s.wi());
        let close = |pdf: f32| (f64::from(pdf) / twin - 1.0).abs() < 1.0e-3;
        let expected = environment_radiance(map, local * s.wi());
        let radiance = (d3(s.radiance) - expected).abs().max_element() < 1.0e-3 * brightest;
        at_borders += usize::from(!close(s.pdf) || !close(s.along_wi.pdf) || !radiance);
        assert_eq!(s.radiance, s.along_wi.radiance);
    }
    assert!(at_borders <= drawn.len() / 1000, "{name}: {at_borders} samples differ from the twin");
}

/// Fails unless the mean of radiance over density agrees with the map's integral.
fn check_flux(name: &str, drawn: &[LightOutput], map: &EnvironmentMap) {
    let estimates = drawn.iter().map(|s| d3(s.radiance).element_sum() / 3.0 / f64::from(s.pdf));
    let estimate = mean_and_error(estimates);
    let flux = flux(map);
    println!("{name}: flux {estimate:?}, {flux} by quadrature");
    assert!(within_four_sigma(estimate, flux), "{name}: {estimate:?}, not {flux}");
    assert!(!within_four_sigma(estimate, 1.05 * flux), "{name}: the twin {estimate:?}");
}

#[test]
fn directions_to_a_constant_environment_are_uniform() {
    let mut scene = empty_scene();
    scene.environment = Some(Environment::constant(vec3(0.5, 1.0, 2.0)));
    let drawn = draw_from(&scene, DVec3::ONE, SAMPLES, 51);
    let uniform = |power: f64| {
        let pair = |s: &LightOutput| {
            let w = s.wi();
            (((w.z + 1.0) / 2.0).powf(power), (w.y.atan2(w.x) / TAU).rem_euclid(1.0))
        };
        pair_uniformity(drawn.iter().map(pair), 16)
    };
    assert!(uniform(1.0) > SIGNIFICANCE && uniform(1.05) < SIGNIFICANCE, "{} {}", uniform(1.0), uniform(1.05));
    for s in &drawn {
        assert!((f64::from(s.pdf) * 2.0 * TAU - 1.0).abs() < 1.0e-6 && s.pdf == s.along_wi.pdf, "{s:?}");
        assert_eq!((s.radiance, s.along_wi.radiance), ([0.5, 1.0, 2.0], [0.5, 1.0, 2.0]));
    }
}

fn fixture() -> Value {
    serde_json::from_str(include_str!("../data/emitters/mitsuba.json")).expect("JSON")
}

fn vector(value: &Value) -> DVec3 {
    let number = |i: usize| value[i].as_f64().expect("a number");
    DVec3::new(number(0), number(1), number(2))
}

/// Whether the device's radiance agrees with Mitsuba's, multiplied by `factor`.
fn radiances_agree(case: &Value, factor: f64) -> bool {
    let scene = parse(case["xml"].as_str().expect("XML"));
    let samples = case["directions"].as_array().expect("an array");
    let input = |s: &Value| LightInput { from: [0.0; 3], direction: vector(&s["direction"]).as_vec3().into() };
    let inputs: Vec<_> = samples.iter().map(input).collect();
    let pairs = draw(&scene, &inputs, 0).into_iter().zip(samples);
    let error = |(o, s): (LightOutput, &Value)| {
        let expected = vector(&s["radiance"]) * factor;
        ((d3(o.along_direction.radiance) - expected) / expected.abs().max(DVec3::splat(1.0e-3))).abs().max_element()
    };
    let worst = pairs.map(error).fold(0.0, f64::max);
    println!("{factor}: {worst:?} off, {}", case["xml"]);
    // Maps are stored in half precision.
    worst < 5.0e-4
}

#[test]
fn environments_are_mitsubas() {
    for case in fixture()["environments"].as_array().expect("an array") {
        assert!(radiances_agree(case, 1.0), "{case}");
        assert!(!radiances_agree(case, 1.002), "the twin of {case}");
    }
}

/// Largest error of the device against Mitsuba's answers, multiplied by `factor`, and against the twin.
fn delta_errors(case: &Value, factor: f64) -> [f64; 2] {
    let scene = parse(case["xml"].as_str().expect("XML"));
    let kind = scene.delta_emitters[0].kind;
    let samples = case["points"].as_array().expect("an array");
    let input = |s: &Value| LightInput { from: vector(&s["from"]).as_vec3().into(), direction: [0.0, 0.0, 1.0] };
    let drawn = draw(&scene, &samples.iter().map(input).collect::<Vec<_>>(), 0);
    let mut worst = [0.0_f64; 2];
    for (o, s) in drawn.iter().zip(samples) {
        assert_eq!((o.pdf, o.delta, o.infinite), (1.0, 1, u32::from(kind.plugin() == "directional")));
        let error = |(wi, irradiance): (DVec3, DVec3)| {
            let relative = (d3(o.radiance) - irradiance).length() / irradiance.length().max(1.0e-2);
            relative.max((o.wi() - wi).length())
        };
        let mitsubas = (vector(&s["wi"]), factor * vector(&s["irradiance"]));
        worst = [worst[0].max(error(mitsubas)), worst[1].max(error(delta_light(&kind, d3(input(s).from))))];
    }
    println!("{factor}: {worst:?} off, {}", case["xml"]);
    worst
}

#[test]
fn delta_lights_are_mitsubas() {
    for case in fixture()["delta_emitters"].as_array().expect("an array") {
        assert!(delta_errors(case, 1.0).iter().all(|error| *error < 1.0e-4), "{}", case["xml"]);
        assert!(delta_errors(case, 1.001)[0] > 1.0e-4, "the twin of {}", case["xml"]);
    }
}

/// Lights are chosen in proportion to their power. One scene has lights of every kind, and the samples of each are
/// counted.
#[test]
fn lights_are_chosen_by_their_power() {
    let radius = (0.75_f64).sqrt();
    let mut scene = empty_scene();
    scene.emitters.push(AreaEmitter::new(Textured::constant(Vec3::splat(2.0))));
    let half = Primitive {
        shape: PrimitiveShape::Parallelogram,
        origin: vec3(0.5, 0.5, 0.0),
        edge_u: vec3(0.5, 0.0, 0.0),
        edge_v: vec3(0.0, 0.5, 0.0),
        normals: None,
        uvs: Default::default(),
        flip_normal: false,
        front_only: false,
        unseen: false,
        material: 0,
        emitter: Some(0),
    };
    // The two primitives together span the unit cube.
    scene.primitives = vec![half, Primitive { origin: vec3(0.5, 0.5, 1.0), emitter: None, ..half }];
    let (position, direction, color) = (vec3(3.0, 0.0, 0.0), Vec3::Z, Vec3::ONE);
    let spot = DeltaKind::Spot { position, direction, intensity: color, cutoff_angle: 0.5, beam_width: 0.5 };
    scene.delta_emitters = [
        (DeltaKind::Point { position: -position, intensity: color }, 1.0),
        (spot, 0.5),
        (DeltaKind::Directional { direction, irradiance: color }, 2.0),
    ]
    .map(|(kind, sampling_weight)| DeltaEmitter { kind, sampling_weight })
    .to_vec();
    scene.environment = Some(Environment { sampling_weight: 0.25, ..Environment::constant(color) });
    let disk = PI * radius * radius;
    let powers = [2.0 * PI, 4.0 * PI, 0.5 * TAU * (1.0 - 0.5_f64.cos()), 2.0 * disk, 0.25 * 4.0 * PI * disk];
    let mut counts = [0; 5];
    for s in draw_from(&scene, vec3(0.5, 0.5, 0.5).as_dvec3(), SAMPLES, 61) {
        let light = match (s.delta, s.infinite) {
            (0, 0) => 0,
            (1, 0) if s.target[0] < 0.0 => 1,
            (1, 0) => 2,
            (1, _) => 3,
            _ => 4,
        };
        counts[light] += 1;
        let probability = powers[light] / powers.iter().sum::<f64>();
        assert!(s.delta == 0 || (f64::from(s.pdf) / probability - 1.0).abs() < 1.0e-5, "{s:?}, not {probability}");
    }
    let expected = |factor: f64| {
        let sum: f64 = powers.iter().sum::<f64>() + (factor - 1.0) * powers[1];
        let power = |i: usize| if i == 1 { factor * powers[i] } else { powers[i] };
        [0, 1, 2, 3, 4].map(|i| power(i) / sum * SAMPLES as f64)
    };
    let p = chi_square(&counts, &expected(1.0));
    assert!(p > SIGNIFICANCE && chi_square(&counts, &expected(1.05)) < SIGNIFICANCE, "{p}: {counts:?}");
}
