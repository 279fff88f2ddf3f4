//! Blends, two-sided pairs and holes, in a furnace with a closed form.

use glam::{Mat3, Vec3};
use lodestar::scene::bsdf::Principled;
use lodestar::scene::texture::{Pattern, Texture};
use lodestar::scene::{
    Bsdf, Environment, Material, MaterialKind, Scene, SurfaceMaterial, Textured, emitter::AreaEmitter,
};
use lodestar::settings::Sampler;
use support::estimate::Estimate;
use support::scenes::{SAMPLERS, ours, settings};
use support::significance::{ALPHA, sidak, two_sided};

use crate::device::Device;

const SIZE: [u32; 2] = [32, 32];
const SPP: u32 = 128;
const EDGES: u32 = 6;
/// Number of tests of this file, for all samplers, with and without emitter sampling.
const CASES: usize = 12 * SAMPLERS.len();
const EMISSION: f64 = 0.5;
/// Radiance around the furnace.
const OUTSIDE: f32 = 0.3;

fn diffuse(albedo: f32) -> SurfaceMaterial {
    SurfaceMaterial::plain(Bsdf::Diffuse { reflectance: Textured::constant(Vec3::splat(albedo)) })
}

fn material(kind: MaterialKind) -> Material {
    Material { name: String::new(), kind, boundary: None }
}

fn surface(albedo: f32) -> Material {
    material(MaterialKind::Surface(diffuse(albedo)))
}

fn blend(weight: f32, materials: [u32; 2]) -> Material {
    material(MaterialKind::Blend { weight: Textured::constant(weight), materials })
}

fn sides(front: u32, back: u32) -> Material {
    material(MaterialKind::Sides { front, back })
}

/// Closed sphere with the first of `materials`, lit from inside and outside.
fn furnace(materials: Vec<Material>) -> Scene {
    let mut scene = ours("furnace/scene.xml", &[]);
    scene.emitters = vec![AreaEmitter::new(Textured::constant(Vec3::splat(EMISSION as f32)))];
    scene.environment = Some(Environment::constant(Vec3::splat(OUTSIDE)));
    scene.materials = materials;
    scene
}

/// Radiance that paths of at most `edges` edges bring. A share `albedo` of the light is reflected, and a share `holes`
/// comes from outside.
fn answer(edges: u32, albedo: f64, holes: f64) -> f64 {
    match edges {
        1 => EMISSION,
        _ => EMISSION + albedo * answer(edges - 1, albedo, holes) + holes * f64::from(OUTSIDE),
    }
}

/// Probabilities that a correct renderer deviates as far from each of the `expected` values.
fn surprise(device: &Device, scene: &Scene, (sampler, nee): (Sampler, bool), expected: [f64; 2]) -> [f64; 2] {
    let mut settings = settings(scene, SIZE, sampler, 9);
    (settings.max_depth, settings.nee) = (EDGES, nee);
    let (mean, error) = Estimate::of(&device.render(scene, &settings, SPP)).gray();
    let z = expected.map(|expected| (mean - expected) / error.hypot(1.0e-6));
    println!("{sampler:?}, emitter sampling {nee}: {mean:.5} +- {error:.5}, not {expected:.5?}: z = {z:.2?}");
    z.map(two_sided)
}

/// Fails unless the picture agrees with `expected`, and disagrees with a value that is 3 % larger.
fn check(name: &str, scene: &Scene, expected: f64) {
    let device = Device::new();
    for how in SAMPLERS.map(|sampler| [false, true].map(|nee| (sampler, nee))).into_iter().flatten() {
        println!("{name}");
        let [p, wrong] = surprise(&device, scene, how, [expected, 1.03 * expected]);
        assert!(sidak(p, CASES) > ALPHA, "{name}, {how:?}: p = {p}");
        assert!(sidak(wrong, CASES) < ALPHA, "the twin, {name}, {how:?}: p = {wrong}");
    }
}

#[test]
fn a_blend_is_the_mean_of_its_parts() {
    let scene = furnace(vec![blend(0.25, [1, 2]), surface(0.3), surface(0.8)]);
    check("blend", &scene, answer(EDGES, 0.75 * 0.3 + 0.25 * 0.8, 0.0));
}

#[test]
fn blends_of_blends_draw_anew() {
    // Paths that have chosen a surface wait for paths that choose again.
    let scene = furnace(vec![blend(0.6, [2, 1]), blend(0.9, [3, 4]), surface(0.1), surface(0.5), surface(0.9)]);
    let albedo = 0.4 * 0.1 + 0.6 * (0.1 * 0.5 + 0.9 * 0.9);
    check("nested blend", &scene, answer(EDGES, albedo, 0.0));
}

/// Blends can be nested as deep as the kernels' loop goes. Each blend takes its surface with probability 1/4.
#[test]
fn blends_may_be_as_deep_as_the_loop_that_follows_them() {
    const DEEPEST: u32 = 8;
    let albedo = |level: u32| 0.1 + 0.1 * level as f32;
    let blends = (0..DEEPEST)
        .map(|level| blend(0.75, [DEEPEST + level, if level + 1 < DEEPEST { level + 1 } else { 2 * DEEPEST }]));
    let surfaces = (0..=DEEPEST).map(|level| surface(albedo(level)));
    let share = |level: u32| 0.75_f64.powi(level as i32) * if level < DEEPEST { 0.25 } else { 1.0 };
    let mean = (0..=DEEPEST).map(|level| share(level) * f64::from(albedo(level))).sum();
    check("deep blend", &furnace(blends.chain(surfaces).collect()), answer(EDGES, mean, 0.0));
}

#[test]
fn the_front_has_the_first_material() {
    let scene = furnace(vec![sides(1, 2), surface(0.6), surface(0.2)]);
    check("front", &scene, answer(EDGES, 0.6, 0.0));
}

/// The back has the second material: half of the light that meets the back passes through. There is no other light.
#[test]
fn the_back_has_the_second_material() {
    let back = SurfaceMaterial { two_sided: true, opacity: Textured::constant(0.5), ..diffuse(0.2) };
    let mut scene = furnace(vec![sides(1, 2), surface(0.6), material(MaterialKind::Surface(back))]);
    scene.emitters.clear();
    for primitive in &mut scene.primitives {
        primitive.flip_normal = !primitive.flip_normal;
        primitive.emitter = None;
    }
    let reflected = |edges: u32| (0.5_f64 * 0.2).powi(edges as i32 - 2);
    check("back", &scene, (2..=EDGES).map(|edges| 0.5 * f64::from(OUTSIDE) * reflected(edges)).sum());
}

#[test]
fn light_goes_straight_through_holes() {
    let mut masked = diffuse(0.7);
    masked.opacity = Textured::constant(0.8);
    let scene = furnace(vec![material(MaterialKind::Surface(masked))]);
    check("mask", &scene, answer(EDGES, 0.8 * 0.7, 0.2));
}

/// The last of eight textures counts, which is the maximum per material. The loop over textures ends at its bound,
/// after the texture of the opacity.
#[test]
fn the_last_of_eight_textures_counts() {
    let gray = |value: f32| Texture {
        name: String::new(),
        pattern: Pattern::Checkerboard { color0: Vec3::splat(value), color1: Vec3::splat(value) },
        to_uv: Mat3::IDENTITY,
    };
    let white = |value: f32| Textured { value, texture: Some(0) };
    let principled = Principled {
        base_color: Textured::constant(Vec3::splat(0.7)),
        roughness: white(0.5),
        anisotropic: white(0.0),
        metallic: white(0.0),
        spec_trans: Textured::constant(0.0),
        eta: 1.5,
        spec_tint: white(0.0),
        sheen: white(0.0),
        sheen_tint: white(0.0),
        flatness: white(0.0),
        clearcoat: Textured::constant(0.0),
        clearcoat_gloss: Textured::constant(0.0),
    };
    let device = Device::new();
    let mean = |opacity: Textured<f32>| {
        let surface = SurfaceMaterial { opacity, ..SurfaceMaterial::plain(Bsdf::Principled(principled.clone())) };
        let mut scene = furnace(vec![material(MaterialKind::Surface(surface))]);
        scene.textures = vec![gray(1.0), gray(0.8)];
        let settings = settings(&scene, SIZE, Sampler::Bsdf, 9);
        Estimate::of(&device.render(&scene, &settings, SPP)).gray().0
    };
    let (textured, constant) = (mean(Textured { value: 1.0, texture: Some(1) }), mean(Textured::constant(0.8)));
    let (seventh, whole) = (mean(Textured { value: 1.0, texture: Some(0) }), mean(Textured::constant(1.0)));
    println!("{textured} {constant}, {seventh} {whole}");
    // The paths are the same, except for rounding of a texture's luminance.
    assert!((textured / constant - 1.0).abs() < 1.0e-3 && (seventh / whole - 1.0).abs() < 1.0e-3);
    assert!((textured / whole - 1.0).abs() > 1.0e-2);
}
