//! Media that are grids: closed forms, a furnace, guided pictures against unguided ones, faults, and bits.

use std::f64::consts::{FRAC_1_PI, PI};
use std::fs;

use lodestar::scene::{LoadOptions, Scene, load};
use lodestar::settings::{Execution, Learner, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::mutated::{GRID_DIMMED_TWICE, LOW_MAJORANTS, OTHER_SIDE, UNWEIGHTED_NULL};
use support::scenes::settings;
use support::significance::ALPHA;
use support::volumes;

use crate::closed_forms::{self, assert_is, surprise};
use crate::device::Device;

/// Densities of the layers of a slab, from z = -1 to 1.
const LAYERS: [f64; 8] = [0.0, 0.3, 1.2, 0.1, 0.0, 0.7, 0.2, 0.9];

/// Scene with files beside it. The camera looks along -z from (0, 0, 4).
fn scene(depth: i32, fov: f64, inside: &str, body: &str) -> Scene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='volpath'><integer name='max_depth' value='{depth}'/></integrator>\
         <sensor type='perspective'><float name='fov' value='{fov}'/><float name='near_clip' value='0.0001'/><transform name='to_world'>\
         <lookat origin='0,0,4' target='0,0,0' up='0,1,0'/></transform>{inside}</sensor>{body}</scene>"
    );
    read("scene.xml", &text)
}

fn read(name: &str, text: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    // Voxels along x and y differ in number, so that a mix-up of axes is found.
    let layers: Vec<f32> = LAYERS.iter().flat_map(|layer| [*layer as f32; 6]).collect();
    let colors: Vec<f32> = layers.iter().flat_map(|layer| [*layer, 0.5 * layer, 2.0 * layer]).collect();
    let files = [
        ("layers.vol", volumes::file([3, 2, 8], &layers)),
        ("colors.vol", volumes::file([3, 2, 8], &colors)),
        ("smoke.vol", volumes::file([17, 21, 19], &volumes::smoke([17, 21, 19], 1))),
        ("tinted.vol", volumes::file([17, 21, 19], &volumes::smoke([17, 21, 19], 3))),
    ];
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    let path = folder.path().join(name);
    fs::write(&path, text).expect("a file");
    load(&path, &LoadOptions::default()).expect("a scene")
}

/// Volume of a file in the cube of side 2 around the origin.
fn volume(name: &str, file: &str, more: &str) -> String {
    format!(
        "<volume name='{name}' type='gridvolume'><string name='filename' value='{file}'/><transform name='to_world'>\
         <translate value='-0.5,-0.5,-0.5'/><scale value='2'/></transform>{more}</volume>"
    )
}

fn medium(side: &str, volumes: &str, scale: f64, phase: &str) -> String {
    format!("<medium name='{side}' type='heterogeneous'>{volumes}<float name='scale' value='{scale}'/>{phase}</medium>")
}

/// A cube of side 2 around the origin.
fn cube(medium: &str) -> String {
    format!("<shape type='cube'><bsdf type='null'/>{medium}</shape>")
}

fn albedo(value: f64) -> String {
    format!("<float name='albedo' value='{value}'/>")
}

const SKY: &str = "<emitter type='constant'/>";
/// Sky of red light, whose gray mean is 1.
const RED_SKY: &str = "<emitter type='constant'><rgb name='radiance' value='3,0,0'/></emitter>";
const HG: &str = "<phase type='hg'><float name='g' value='0.6'/></phase>";

fn mean_of(device: &Device, scene: &Scene, spp: u32, change: impl FnOnce(&mut Settings)) -> (f64, f64) {
    closed_forms::mean_of(device, scene, 47, spp, change)
}

/// Optical depth of the slab along z. Each layer is 1/4 thick, and interpolation only moves its particles.
fn depth(scale: f64) -> f64 {
    0.25 * scale * LAYERS.iter().sum::<f64>()
}

/// The sky through layers, from outside and from inside, by each filter and each border.
#[test]
fn layers_dim_the_sky_by_their_transmittance() {
    let device = Device::new();
    let nearest = "<string name='filter_type' value='nearest'/>";
    let repeat = "<string name='wrap_mode' value='repeat'/>";
    let mirror = "<string name='wrap_mode' value='mirror'/>";
    for (at, border) in ["", nearest, repeat, mirror].into_iter().enumerate() {
        let slab = medium("interior", &(volume("sigma_t", "layers.vol", border) + &albedo(0.0)), 1.3, "");
        let scene = scene(-1, 0.001, "", &(cube(&slab) + SKY));
        let found = mean_of(&device, &scene, 1024, |s| {
            if at % 2 == 1 {
                (s.sampler, s.execution) = (Sampler::Product, Execution::Wavefront);
            }
        });
        assert_is(border, found, (-depth(1.3)).exp());
    }
    // Beyond pbrt's border the density is 0, and it falls to a half there.
    let zero = "<string name='wrap_mode' value='zero'/>";
    let slab = medium("interior", &(volume("sigma_t", "layers.vol", zero) + &albedo(0.0)), 1.3, "");
    let lost = 1.3 * 0.25 * 0.125 * LAYERS[7];
    // In x and y the ray is in the middle, where there are no borders nearby.
    assert_is(
        "zero",
        mean_of(&device, &scene(-1, 0.001, "", &(cube(&slab) + SKY)), 2048, |_| {}),
        (lost - depth(1.3)).exp(),
    );
    // The camera is in the medium, and the grid is smaller than the medium's place.
    let inside = medium("medium", &(volume("sigma_t", "layers.vol", "") + &albedo(0.0)), 1.3, "");
    let lamp = "<shape type='rectangle'><transform name='to_world'><translate z='-3'/></transform><emitter type='area'/></shape>";
    assert_is("inside", mean_of(&device, &scene(-1, 0.001, &inside, lamp), 1024, |_| {}), (-depth(1.3)).exp());
}

/// Channels of the extinction are as 1 : 0.5 : 2.
fn colored_transmittance(scale: f64) -> f64 {
    [1.0, 0.5, 2.0].map(|factor| (-factor * depth(scale)).exp()).iter().sum::<f64>() / 3.0
}

fn colored_slab(sky: &str) -> Scene {
    let slab = medium("interior", &(volume("sigma_t", "colors.vol", "") + &albedo(0.0)), 1.0, "");
    scene(-1, 0.001, "", &(cube(&slab) + sky))
}

/// A sun through layers onto a white wall, and back to the camera.
fn wall_behind(slab: &str) -> Scene {
    let wall = "<shape type='rectangle'><transform name='to_world'><scale value='3'/><translate z='-2'/></transform>\
                <bsdf type='diffuse'><float name='reflectance' value='0.8'/></bsdf></shape>\
                <emitter type='directional'><vector name='direction' x='0' y='0' z='-1'/></emitter>";
    scene(-1, 0.001, "", &(cube(slab) + wall))
}

#[test]
fn layers_dim_sampled_lights_by_their_transmittance() {
    let device = Device::new();
    let slab = medium("interior", &(volume("sigma_t", "layers.vol", "") + &albedo(0.0)), 1.3, "");
    let expected = 0.8 * FRAC_1_PI * (-2.0 * depth(1.3)).exp();
    let found = mean_of(&device, &wall_behind(&slab), 2048, |_| {});
    assert_is("wall", found, expected);
    let waves = mean_of(&device, &wall_behind(&slab), 2048, |s| s.execution = Execution::Wavefront);
    assert_is("wall, waves", waves, expected);
    assert_is("colors", mean_of(&device, &colored_slab(SKY), 2048, |_| {}), colored_transmittance(1.0));
    assert_is("red", mean_of(&device, &colored_slab(RED_SKY), 2048, |_| {}), (-depth(1.0)).exp());
}

/// Density of the slab's layers at a height, interpolated.
fn density(z: f64) -> f64 {
    if z.abs() > 1.0 {
        return 0.0;
    }
    let place = (z + 1.0) * 4.0 - 0.5;
    let (low, share) = (place.floor(), place - place.floor());
    let layer = |i: f64| LAYERS[i.clamp(0.0, 7.0) as usize];
    layer(low) * (1.0 - share) + layer(low + 1.0) * share
}

/// Optical depth of unit density between two heights, along z.
fn between(from: f64, to: f64) -> f64 {
    let steps = 400;
    let step = (to - from) / f64::from(steps);
    (0..steps).map(|i| density(from + (f64::from(i) + 0.5) * step) * step.abs()).sum()
}

/// Light of a point light at (0.8, 0, 0.2) in the layers, scattered once into the camera's ray along z.
#[test]
fn single_scattering_of_a_point_light_in_layers_is_its_integral() {
    let device = Device::new();
    let light = "<emitter type='point'><point name='position' x='0.8' y='0' z='0.2'/></emitter>";
    let scale = 1.5;
    let slab = medium("interior", &(volume("sigma_t", "layers.vol", "") + &albedo(0.9)), scale, HG);
    // The camera's ray crosses the border of the cube first.
    let scene = scene(3, 0.001, "", &(cube(&slab) + light));
    let steps = 1000;
    let term = |i: i32| {
        let z = 1.0 - (f64::from(i) + 0.5) * 2.0 / f64::from(steps);
        let along = z - 0.2;
        let r = along.hypot(0.8);
        let slant = if along.abs() < 1.0e-9 { 0.0 } else { between(0.2, z) * r / along.abs() };
        // The light travels from the light to the point, and on along +z.
        let cosine = along / r;
        let phase = (1.0 - 0.36) / (4.0 * PI * (1.36 - 1.2 * cosine).powf(1.5));
        let depth = scale * (slant + between(z, 1.0));
        0.9 * scale * density(z) * phase * (-depth).exp() / (r * r) * 2.0 / f64::from(steps)
    };
    let expected: f64 = (0..steps).map(term).sum();
    assert_is("point", mean_of(&device, &scene, 4096, |_| {}), expected);
    let waves = mean_of(&device, &scene, 4096, |s| (s.sampler, s.execution) = (Sampler::Product, Execution::Wavefront));
    assert_is("point, waves", waves, expected);
}

#[test]
fn faults_of_grids_are_found_in_closed_forms() {
    let device = Device::new();
    let slab = medium("interior", &(volume("sigma_t", "layers.vol", "") + &albedo(0.0)), 1.3, "");
    let wall = 0.8 * FRAC_1_PI * (-2.0 * depth(1.3)).exp();
    for (fault, scene, expected) in [
        (GRID_DIMMED_TWICE, wall_behind(&slab), wall),
        (OTHER_SIDE, wall_behind(&slab), wall),
        (LOW_MAJORANTS, colored_slab(SKY), colored_transmittance(1.0)),
        // The sum of the channels does not depend on these weights.
        (UNWEIGHTED_NULL, colored_slab(RED_SKY), (-depth(1.0)).exp()),
    ] {
        let found = mean_of(&device.mutated(fault), &scene, 1024, |_| {});
        assert!(surprise(found, expected) < ALPHA, "{fault}: {found:?}, {expected}");
    }
}

/// A medium that only scatters is invisible under an even sky, however its densities and colors vary.
#[test]
fn a_grid_that_only_scatters_is_invisible_in_a_furnace() {
    let device = Device::new();
    for (at, (file, phase)) in [("smoke.vol", HG), ("tinted.vol", ""), ("tinted.vol", HG)].into_iter().enumerate() {
        let smoke = medium("interior", &(volume("sigma_t", file, "") + &albedo(1.0)), 9.0, phase);
        let scene = scene(-1, 40.0, "", &(cube(&smoke) + SKY));
        let found = mean_of(&device, &scene, 256, |s| {
            s.nee = at != 1;
            if at > 0 {
                (s.sampler, s.execution) = (Sampler::Product, Execution::Wavefront);
            }
        });
        assert_is(file, found, 1.0);
    }
}

/// Light of media: a grid of even density, and a homogeneous medium, that absorb and emit.
#[test]
fn media_that_glow_have_their_closed_form() {
    let device = Device::new();
    let file = |medium: &str| {
        let text = format!(
            "LookAt 0 0 4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 0.001 Film \"rgb\" \"integer xresolution\" 16 \
             \"integer yresolution\" 16 Integrator \"volpath\" \"integer maxdepth\" 50 WorldBegin \
             MakeNamedMedium \"glow\" {medium} MediumInterface \"glow\" \"\" Material \"interface\" Translate 0 0 1 \
             Shape \"sphere\" \"float radius\" 1"
        );
        read("scene.pbrt", &text)
    };
    let common = "\"rgb sigma_a\" [ 0.6 0.6 0.6 ] \"rgb sigma_s\" [ 0 0 0 ] \"rgb Le\" [ 2 2 2 ]";
    let expected = 2.0 * (1.0 - (-1.2f64).exp());
    let even = file(&format!("\"string type\" \"homogeneous\" {common}"));
    let found = mean_of(&device, &even, 2048, |s| s.execution = Execution::Wavefront);
    assert_is("homogeneous", found, expected);
    // The box is larger than the sphere, so that no border is near: pbrt's grids fall to a half there.
    let ones = "1 ".repeat(64);
    let grid = |kind: &str, values: &str| {
        format!(
            "\"string type\" \"{kind}\" {values} \"integer nx\" 4 \"integer ny\" 4 \"integer nz\" 4 \
             \"point3 p0\" [ -3 -3 -2 ] \"point3 p1\" [ 3 3 4 ]"
        )
    };
    let uniform = grid("uniformgrid", &format!("{common} \"float density\" [ {ones} ] \"float Lescale\" [ {ones} ]"));
    assert_is("uniformgrid", mean_of(&device, &file(&uniform), 2048, |_| {}), expected);
    let colors = |value: &str| format!("{value} ").repeat(192);
    let rgb = format!(
        "\"rgb sigma_a\" [ {} ] \"rgb sigma_s\" [ {} ] \"rgb Le\" [ {} ]",
        colors("0.6"),
        colors("0"),
        colors("1")
    );
    let rgb = grid("rgbgrid", &(rgb + " \"float Lescale\" 2"));
    let waves = mean_of(&device, &file(&rgb), 2048, |s| s.execution = Execution::Wavefront);
    assert_is("rgbgrid", waves, expected);
}

/// A smoky room, lit by a small lamp through a slit.
fn smoky_room() -> Scene {
    let wall = |steps: &str, albedo: &str| {
        format!(
            "<shape type='rectangle'><transform name='to_world'>{steps}</transform><bsdf type='twosided'><bsdf type='diffuse'>\
             <rgb name='reflectance' value='{albedo}'/></bsdf></bsdf></shape>"
        )
    };
    let smoke = volume("sigma_t", "tinted.vol", "") + &volume("albedo", "smoke.vol", "");
    let room = [
        wall("<scale value='5'/><translate z='-2'/>", "0.6,0.6,0.6"),
        wall("<scale value='5'/><rotate x='1' angle='-90'/><translate y='-2'/>", "0.3,0.6,0.6"),
        wall("<scale value='5'/><rotate x='1' angle='90'/><translate y='2'/>", "0.6,0.6,0.3"),
        wall("<scale value='5'/><rotate y='1' angle='90'/><translate x='-2'/>", "0.6,0.3,0.3"),
        wall("<scale value='5'/><translate z='5'/>", "0.6,0.6,0.6"),
        wall("<scale x='5' y='0.8'/><rotate y='1' angle='-90'/><translate x='2' y='-1.2'/>", "0.6,0.6,0.6"),
        wall("<scale x='5' y='0.8'/><rotate y='1' angle='-90'/><translate x='2' y='1.2'/>", "0.6,0.6,0.6"),
        "<shape type='rectangle'><transform name='to_world'><scale x='2' y='1'/><rotate y='1' angle='-90'/><translate x='4'/>\
         </transform><emitter type='area'><rgb name='radiance' value='40,38,30'/></emitter></shape>"
            .into(),
        cube(&medium("interior", &smoke, 3.0, HG)),
    ];
    scene(-1, 60.0, "", &room.concat())
}

#[test]
fn guided_pictures_of_smoke_agree_with_unguided_ones() {
    let device = Device::new();
    let scene = smoky_room();
    let render = |device: &Device, sampler, learner, nee, seed, spp| {
        let settings = Settings { nee, learner, ..settings(&scene, [24, 24], sampler, seed) };
        Estimate::of(&device.render(&scene, &settings, spp))
    };
    let unguided = render(&device, Sampler::Bsdf, Learner::Sarsa, true, 1, 1024);
    for (seed, (sampler, learner, nee)) in
        (2..).zip([(Sampler::Product, Learner::Sarsa, true), (Sampler::RejectionMix, Learner::MonteCarlo, false)])
    {
        let right = Comparison::new(&unguided, &render(&device, sampler, learner, nee, seed, 384), &[6, WHOLE]);
        println!("{sampler:?} {learner:?}: {right:?}");
        assert!(right.agrees(), "{sampler:?}: {right:?}");
    }
    let wrong = render(&device.mutated(GRID_DIMMED_TWICE), Sampler::Product, Learner::Sarsa, true, 9, 384);
    let wrong = Comparison::new(&unguided, &wrong, &[6, WHOLE]);
    assert!(!wrong.agrees(), "{wrong:?}");
}

#[test]
fn waves_and_one_kernel_render_the_same_bits_of_smoke() {
    let device = Device::new();
    let scene = smoky_room();
    for sampler in [Sampler::Bsdf, Sampler::Product] {
        let render = |execution| {
            let settings = Settings { nee: true, execution, ..settings(&scene, [24, 24], sampler, 7) };
            let picture = device.render(&scene, &settings, 32);
            (picture.rgb().to_vec(), picture.albedo().to_vec(), picture.depth().to_vec())
        };
        assert!(render(Execution::Megakernel) == render(Execution::Wavefront), "{sampler:?}");
    }
}
