//! Bump and normal maps with a constant slope, on a diffuse floor under a uniform sky or a sun.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3, Mat3, Mat4, Vec3, Vec4, dvec3};
use lodestar::scene::bsdf::{Relief, ReliefRules};
use lodestar::scene::emitter::DeltaKind;
use lodestar::scene::program::Operation;
use lodestar::scene::program::graph::{Graph, Operand};
use lodestar::scene::program::schedule::schedule;
use lodestar::scene::texture::{Image, Pattern, TexelFilter, Texels, Texture, WrapMode};
use lodestar::scene::{Bsdf, DeltaEmitter, Environment, PrimitiveShape, Scene, Textured};
use lodestar::settings::{Sampler, Settings};
use support::estimate::Estimate;
use support::mutated::TILTED_BACK;
use support::scenes::{SAMPLERS, ours, settings, surface_mut};
use support::significance::{ALPHA, sidak, two_sided};
use support::twins::relief::{bump_normal, mapped_normal, relief_frame, relief_shadowing};

use crate::device::Device;

const SIZE: [u32; 2] = [16, 16];
const SPP: u32 = 256;
const ALBEDO: f64 = 0.5;
/// Number of tests of this file, for all samplers, with and without emitter sampling.
const CASES: usize = 13;

/// Sides of the floor in world space. The floor's uv frame is 2 by 4 units large and is not axis-aligned.
const U: Vec3 = Vec3::new(0.6, 0.8, 0.0);
const V: Vec3 = Vec3::new(-1.6, 1.2, 0.0);

fn texture(texels: Vec<[f32; 4]>) -> (Texture, Image) {
    let image = Image { name: String::new(), width: texels.len() as u32, height: 1, texels: Texels::Floats(texels) };
    let pattern = Pattern::Bitmap { image: 0, filter: TexelFilter::Bilinear, wrap: WrapMode::Clamp };
    (Texture { name: String::new(), pattern, to_uv: Mat3::IDENTITY }, image)
}

fn gray(value: f32) -> [f32; 4] {
    [value, value, value, 1.0]
}

/// Floor with a relief, seen from the front or from behind.
fn floor(relief: Relief, texels: Vec<[f32; 4]>, behind: bool) -> Scene {
    let mut scene = ours("furnace/scene.xml", &[]);
    let mut floor = scene.primitives[0];
    floor.shape = PrimitiveShape::Parallelogram;
    (floor.origin, floor.edge_u, floor.edge_v) = (Vec3::ZERO, U, V);
    (floor.flip_normal, floor.emitter) = (false, None);
    scene.primitives = vec![floor];
    scene.emitters.clear();
    scene.environment = Some(Environment::constant(Vec3::ONE));
    let surface = surface_mut(&mut scene.materials[0]);
    (surface.two_sided, surface.relief) = (true, Some(relief));
    let (texture, image) = texture(texels);
    (scene.textures, scene.images) = (vec![texture], vec![image]);
    // The camera sees a small part of the middle, at right angles.
    let side = if behind { -1.0 } else { 1.0 };
    let (forward, up) = (Vec3::new(0.0, 0.0, -side), Vec3::Y);
    let axes = [up.cross(forward), up, forward].map(|axis| axis.extend(0.0));
    scene.camera.world_from_camera = Mat4::from_cols(axes[0], axes[1], axes[2], Vec4::new(0.0, 0.0, 8.0 * side, 1.0));
    scene.camera.fov = 1.0;
    scene
}

/// Radiance of a floor with normal `n` in its uv frame. The normal is mirrored if the floor is seen from behind.
fn answer(n: DVec3) -> f64 {
    answer_with(n, relief_shadowing)
}

/// Radiance of such a floor with another factor of shadowing.
fn answer_with(n: DVec3, shadowing: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let frame = relief_frame(n, DVec3::Z);
    let count = 400;
    let mut sum = 0.0;
    for i in 0..count {
        let theta = (f64::from(i) + 0.5) / f64::from(count) * FRAC_PI_2;
        for j in 0..count {
            let phi = (f64::from(j) + 0.5) / f64::from(count) * TAU;
            let wi = dvec3(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            sum += frame.z_axis.dot(wi).max(0.0) * shadowing(frame.z_axis, wi) * theta.sin();
        }
    }
    ALBEDO / PI * sum * FRAC_PI_2 * TAU / f64::from(count * count)
}

/// Texture that is computed.
fn program(make: impl FnOnce(&mut Graph) -> Operand, limits: [f32; 2]) -> Texture {
    let mut graph = Graph::default();
    let root = make(&mut graph);
    let program = schedule(&graph, root, limits).expect("a program");
    Texture { name: String::new(), pattern: Pattern::Program(program), to_uv: Mat3::IDENTITY }
}

/// Floor whose height and reflectance are computed: the height rises by 0.8 along a unit of the first edge, and the reflectance is half of the
/// normal's length along the z-axis.
fn computed_floor(behind: bool) -> Scene {
    let mut scene = floor(Relief::Bump { texture: 0, scale: 1.0 }, vec![gray(0.0)], behind);
    let along = 0.8 * U;
    let height = |graph: &mut Graph| graph.add(Operation::Dot, &[Operand::Position, Operand::Constant(along)], &[]);
    let reflectance = |graph: &mut Graph| {
        let length = graph.add(Operation::Absolute, &[Operand::Normal], &[]);
        let z = graph.add(Operation::Component, &[length], &[2]);
        graph.add(Operation::Multiply, &[z, Operand::Constant(Vec3::splat(ALBEDO as f32))], &[])
    };
    scene.textures = vec![program(height, [f32::MIN, f32::MAX]), program(reflectance, [0.0, 1.0])];
    scene.images.clear();
    let surface = surface_mut(&mut scene.materials[0]);
    surface.bsdf = Bsdf::Diffuse { reflectance: Textured { value: Vec3::ONE, texture: Some(1) } };
    scene
}

fn check(name: &str, scene: &Scene, expected: f64) {
    let device = Device::new();
    for (sampler, nee) in SAMPLERS.map(|sampler| [false, true].map(|nee| (sampler, nee))).into_iter().flatten() {
        let settings = Settings { nee, ..settings(scene, SIZE, sampler, 4) };
        let (mean, error) = Estimate::of(&device.render(scene, &settings, SPP)).gray();
        let z = |expected: f64| (mean - expected) / error.hypot(1.0e-5);
        println!(
            "{name}, {sampler:?}, emitter sampling {nee}: {mean:.5} +- {error:.5}, not {expected:.5}: z = {:.2}",
            z(expected)
        );
        assert!(sidak(two_sided(z(expected)), CASES) > ALPHA, "{name}, {sampler:?}, {nee}: z = {}", z(expected));
        assert!(sidak(two_sided(z(1.03 * expected)), CASES) < ALPHA, "the twin, {name}, {sampler:?}, {nee}");
    }
}

/// Radiance of the floor under a sun of irradiance pi, at `wi` in the floor's frame.
fn sunlit(n: DVec3, wi: DVec3) -> f64 {
    let n = relief_frame(n, DVec3::Z).z_axis;
    ALBEDO * n.dot(wi).max(0.0) * relief_shadowing(n, wi)
}

/// An error unless the floor under a sun has the closed form's radiance. Only the path to the sun carries light, so there
/// is no noise.
fn check_sun(name: &str, device: &Device, scene: &Scene, n: DVec3) -> Result<(), String> {
    let behind = scene.camera.world_from_camera.w_axis.z < 0.0;
    let [u, v] = [U, V].map(|edge| edge.as_dvec3().normalize());
    let normal = if behind { -DVec3::Z } else { DVec3::Z };
    let mut told_apart = false;
    for wi in [dvec3(0.1, 0.2, 0.9), dvec3(0.7, 0.1, 0.4), dvec3(-0.7, 0.1, 0.4), dvec3(-0.2, -0.8, 0.3)] {
        let wi = wi.normalize();
        let direction = -(wi.x * u + wi.y * v + wi.z * normal).as_vec3();
        let mut scene = scene.clone();
        scene.environment = None;
        let kind = DeltaKind::Directional { direction, irradiance: Vec3::splat(PI as f32) };
        scene.delta_emitters = vec![DeltaEmitter { kind, sampling_weight: 1.0 }];
        let settings = Settings { nee: true, ..settings(&scene, SIZE, Sampler::Bsdf, 4) };
        let (mean, _) = Estimate::of(&device.render(&scene, &settings, 1)).gray();
        let expected = sunlit(n, wi);
        println!("{name}, sun at {wi:.2}: {mean:.5}, not {expected:.5}");
        // The camera's rays are within half a degree of the normal.
        if (mean - expected).abs() >= 1.0e-4 {
            return Err(format!("{name}, sun at {wi}: {mean}, not {expected}"));
        }
        let turned = sunlit(n * dvec3(-1.0, -1.0, 1.0), wi);
        told_apart |= (mean - turned).abs() > 1.0e-2;
    }
    assert!(told_apart, "the twin that is turned about the normal, {name}");
    Ok(())
}

#[test]
fn a_bump_map_tilts_by_its_slope() {
    // Between the texels' centers, half a unit of u apart, the height rises by 0.8. The scale doubles it to 1.6.
    let scene = |behind| floor(Relief::Bump { texture: 0, scale: 2.0 }, vec![gray(0.1), gray(0.9)], behind);
    let [u, v] = [U, V].map(|edge| 2.0 * edge.as_dvec3());
    let n = bump_normal(u.length() * DVec3::X, v.length() * DVec3::Y, DVec2::new(2.0 * 0.8 * 2.0, 0.0), DVec3::Z);
    check("bump", &scene(false), answer(n));
    check_sun("bump", &Device::new(), &scene(false), n).unwrap();
    check_sun("bump from behind", &Device::new(), &scene(true), n).unwrap();
}

#[test]
fn a_normal_map_tilts_by_its_color() {
    let color = [0.9, 0.3, 0.8, 1.0];
    let scene = |behind| floor(Relief::NormalMap { texture: 0 }, vec![color], behind);
    let n = mapped_normal(dvec3(0.9, 0.3, 0.8));
    check("normal map", &scene(false), answer(n));
    check_sun("normal map", &Device::new(), &scene(false), n).unwrap();
    check_sun("normal map from behind", &Device::new(), &scene(true), n).unwrap();
}

#[test]
fn a_computed_height_tilts_by_its_slope() {
    // One unit of u is two units long.
    let [u, v] = [U, V].map(|edge| 2.0 * edge.as_dvec3());
    let n = bump_normal(u.length() * DVec3::X, v.length() * DVec3::Y, DVec2::new(0.8 * u.length(), 0.0), DVec3::Z);
    check("computed bump", &computed_floor(false), answer(n));
    check_sun("computed bump", &Device::new(), &computed_floor(false), n).unwrap();
    check_sun("computed bump from behind", &Device::new(), &computed_floor(true), n).unwrap();
    check_sun("computed bump", &Device::new().mutated(TILTED_BACK), &computed_floor(false), n)
        .expect_err("a slope of the wrong sign must be seen");
}

/// A floor whose relief casts no soft shadows.
#[test]
fn a_relief_without_its_shadowing_function_is_brighter() {
    let tilt = [0.85, 0.3, 0.8, 1.0];
    let n = mapped_normal(dvec3(0.85, 0.3, 0.8)).normalize();
    let mut scene = floor(Relief::NormalMap { texture: 0 }, vec![tilt], false);
    surface_mut(&mut scene.materials[0]).relief_rules.shadows = false;
    let expected = answer_with(n, |_, _| 1.0);
    assert!(expected > 1.05 * answer(n), "{expected} {}", answer(n));
    check("without shadows", &scene, expected);
}

/// A mirror whose relief would send the camera's rays below the surface is black. With normals that are raised, it shows the sky near
/// the horizon.
#[test]
fn a_mirror_with_raised_normals_shows_the_horizon() {
    let device = Device::new();
    // At 60 degrees to the surface's normal, along its first side.
    let (sin, cos) = (0.75_f32.sqrt(), 0.5);
    let mut scene =
        floor(Relief::NormalMap { texture: 0 }, vec![[0.5 * (sin + 1.0), 0.5, 0.5 * (cos + 1.0), 1.0]], false);
    let surface = surface_mut(&mut scene.materials[0]);
    let white = Textured::constant(Vec3::ONE);
    surface.bsdf = Bsdf::Conductor { eta: Vec3::ZERO, k: Vec3::ONE, specular_reflectance: white };
    for (rules, expected) in
        [(ReliefRules { shadows: false, raises: false }, 0.0), (ReliefRules { shadows: false, raises: true }, 1.0)]
    {
        surface_mut(&mut scene.materials[0]).relief_rules = rules;
        for sampler in SAMPLERS {
            let (mean, _) = Estimate::of(&device.render(&scene, &settings(&scene, SIZE, sampler, 4), 4)).gray();
            assert!((mean - expected).abs() < 1.0e-4, "{rules:?}, {sampler:?}: {mean}, not {expected}");
        }
    }
    // A mirror that needs no cure keeps its picture.
    let mut level = floor(Relief::NormalMap { texture: 0 }, vec![[0.6, 0.5, 0.9, 1.0]], false);
    surface_mut(&mut level.materials[0]).bsdf = surface_mut(&mut scene.materials[0]).bsdf.clone();
    let mut render = |raises| {
        surface_mut(&mut level.materials[0]).relief_rules.raises = raises;
        Estimate::of(&device.render(&level, &settings(&level, SIZE, Sampler::Bsdf, 4), 4)).gray().0
    };
    assert!((render(false) - render(true)).abs() < 1.0e-6 && render(true) > 0.9);
}
