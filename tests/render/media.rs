//! Homogeneous media: closed forms, a furnace, guided pictures against unguided ones, and bits.

use std::f64::consts::PI;

use lodestar::scene::{LoadOptions, Scene, load};
use lodestar::settings::{Execution, Learner, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::mutated::{DIMMED_TWICE, OTHER_PHASE, OTHER_SIDE};
use support::scenes::settings;
use support::significance::ALPHA;
use support::tier;

use crate::closed_forms::{self, assert_is, surprise};
use crate::device::Device;

/// A scene with a camera that looks along -z from (0, 0, 4). `inside` stands in the sensor.
fn scene(depth: i32, fov: f64, inside: &str, body: &str) -> Scene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='volpath'><integer name='max_depth' value='{depth}'/></integrator>\
         <sensor type='perspective'><float name='fov' value='{fov}'/><float name='near_clip' value='0.0001'/><transform name='to_world'>\
         <lookat origin='0,0,4' target='0,0,0' up='0,1,0'/></transform>{inside}</sensor>{body}</scene>"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, text).expect("a file");
    load(&path, &LoadOptions::default()).expect("a scene")
}

fn medium(side: &str, extinction: f64, albedo: f64, phase: &str) -> String {
    format!(
        "<medium name='{side}' type='homogeneous'><float name='sigma_t' value='{extinction}'/>\
         <float name='albedo' value='{albedo}'/>{phase}</medium>"
    )
}

/// A cube of side 2 around the origin.
fn cube(bsdf: &str, medium: &str) -> String {
    format!("<shape type='cube'><bsdf type='{bsdf}'/>{medium}</shape>")
}

const SKY: &str = "<emitter type='constant'/>";
const HG: &str = "<phase type='hg'><float name='g' value='0.6'/></phase>";
const RAYLEIGH: &str = "<phase type='rayleigh'/>";
const BLEND: &str = "<phase type='blendphase'><float name='weight' value='0.25'/><phase type='hg'>\
                     <float name='g' value='-0.3'/></phase><phase type='rayleigh'/></phase>";

/// Density of a lobe at this cosine to the direction straight on.
fn hg(g: f64, cosine: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

fn rayleigh(cosine: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
}

/// Density of a phase function.
fn phase(text: &str, cosine: f64) -> f64 {
    match text {
        HG => hg(0.6, cosine),
        RAYLEIGH => rayleigh(cosine),
        BLEND => 0.75 * hg(-0.3, cosine) + 0.25 * rayleigh(cosine),
        _ => hg(0.0, cosine),
    }
}

fn mean_of(device: &Device, scene: &Scene, spp: u32, change: impl FnOnce(&mut Settings)) -> (f64, f64) {
    closed_forms::mean_of(device, scene, 31, spp, change)
}

/// Ways to render.
const WAYS: [(Sampler, Execution, bool); 4] = [
    (Sampler::Bsdf, Execution::Megakernel, true),
    (Sampler::Product, Execution::Wavefront, true),
    (Sampler::Bsdf, Execution::Wavefront, false),
    (Sampler::Product, Execution::Megakernel, false),
];

/// The sky through a slab that absorbs, from far away and from within, thin and thick, small and large.
#[test]
fn a_slab_dims_the_sky_by_its_transmittance() {
    let device = Device::new();
    for &(sampler, execution, nee) in tier::some_of(&WAYS, 2) {
        for depth in [0.01, 1.0, 2.0] {
            let slab = cube("null", &medium("interior", 0.5 * depth, 0.0, "")) + SKY;
            let found = mean_of(&device, &scene(-1, 0.001, "", &slab), 512, |s| {
                (s.sampler, s.execution, s.nee) = (sampler, execution, nee);
            });
            if depth > 0.1 {
                assert_is("slab", found, (-depth).exp());
            } else {
                assert!(surprise(found, (-depth).exp()) > ALPHA && surprise(found, 1.0) < ALPHA, "{found:?}");
            }
        }
    }
    // The camera stands in the medium, and so does a lamp 4 away.
    let lamp = "<shape type='rectangle'><emitter type='area'/></shape>";
    let inside = medium("medium", 0.3, 0.0, "");
    assert_is("lamp in fog", mean_of(&device, &scene(-1, 0.001, &inside, lamp), 512, |_| {}), (-1.2f64).exp());
}

/// A sun from the side into a slab that scatters once: sigma_s p E e^(-sigma) integrated over the way of the camera's ray.
fn lit_slab(phase_text: &str, boundary: &str) -> Scene {
    let sun = "<emitter type='directional'><vector name='direction' x='0' y='-1' z='0'/></emitter>";
    scene(4, 0.001, "", &(cube(boundary, &medium("interior", 0.8, 0.7, phase_text)) + sun))
}

fn lit_slab_radiance(text: &str) -> f64 {
    0.7 * phase(text, 0.0) * (-0.8f64).exp() * (1.0 - (-1.6f64).exp())
}

#[test]
fn single_scattering_of_a_sun_is_its_closed_form() {
    let device = Device::new();
    for text in ["", HG, RAYLEIGH, BLEND] {
        assert_is(text, mean_of(&device, &lit_slab(text, "null"), 1024, |_| {}), lit_slab_radiance(text));
    }
    let waves = mean_of(&device, &lit_slab(HG, "null"), 1024, |s| s.execution = Execution::Wavefront);
    assert_is("waves", waves, lit_slab_radiance(HG));
}

/// A point light at (1, 0, 0) in endless fog, seen along the z-axis.
#[test]
fn single_scattering_of_a_point_light_is_its_integral() {
    let device = Device::new();
    let light = "<emitter type='point'><point name='position' x='1' y='0' z='0'/></emitter>";
    for text in ["", HG, BLEND] {
        let scene = scene(2, 0.001, &medium("medium", 0.4, 0.9, text), light);
        let steps = 200_000;
        let step = 40.0 / f64::from(steps);
        let term = |i: i32| {
            let t = (f64::from(i) + 0.5) * step;
            let (along, r) = (t - 4.0, (t - 4.0).hypot(1.0));
            // The light travels from the light to the point, and on to the camera at z = 4.
            0.36 * phase(text, -along / r) * (-0.4 * (t + r)).exp() / (r * r) * step
        };
        assert_is(text, mean_of(&device, &scene, 2048, |_| {}), (0..steps).map(term).sum());
    }
}

#[test]
fn faults_of_media_are_found_in_closed_forms() {
    let device = Device::new();
    let expected = lit_slab_radiance("");
    for fault in [DIMMED_TWICE, OTHER_SIDE] {
        let found = mean_of(&device.mutated(fault), &lit_slab("", "null"), 256, |_| {});
        assert!(surprise(found, expected) < ALPHA, "{fault}: {found:?}");
    }
}

/// A furnace: a medium that absorbs nothing is invisible under an even sky, whatever its density, its color, its phase function and its
/// boundary.
#[test]
fn a_medium_that_only_scatters_is_invisible_in_a_furnace() {
    let device = Device::new();
    let colored = |phase: &str| {
        format!(
            "<medium name='interior' type='homogeneous'><rgb name='sigma_t' value='0.2,1,5'/>\
             <float name='albedo' value='1'/>{phase}</medium>"
        )
    };
    let cases = [("null", BLEND), ("dielectric", HG), ("null", RAYLEIGH), ("roughdielectric", "")];
    for (case, (boundary, phase)) in cases.into_iter().enumerate().take(if tier::is_full() { 4 } else { 2 }) {
        for (at, &(sampler, execution, nee)) in WAYS.iter().enumerate() {
            if !tier::is_full() && at % 2 != case % 2 {
                continue;
            }
            let scene = scene(-1, 40.0, "", &(cube(boundary, &colored(phase)) + SKY));
            let found = mean_of(&device, &scene, 256, |s| (s.sampler, s.execution, s.nee) = (sampler, execution, nee));
            // Rough glass loses light between its facets.
            if boundary != "roughdielectric" {
                assert_is(boundary, found, 1.0);
            }
        }
    }
}

/// Fog in a closed room, lit by a small lamp through a slit.
fn foggy_room() -> Scene {
    let wall = |steps: &str, albedo: &str| {
        format!(
            "<shape type='rectangle'><transform name='to_world'>{steps}</transform><bsdf type='twosided'><bsdf type='diffuse'>\
             <rgb name='reflectance' value='{albedo}'/></bsdf></bsdf></shape>"
        )
    };
    let room = [
        wall("<scale value='5'/><translate z='-2'/>", "0.6,0.6,0.6"),
        wall("<scale value='5'/><rotate x='1' angle='-90'/><translate y='-2'/>", "0.3,0.6,0.6"),
        wall("<scale value='5'/><rotate x='1' angle='90'/><translate y='2'/>", "0.6,0.6,0.3"),
        wall("<scale value='5'/><rotate y='1' angle='90'/><translate x='-2'/>", "0.6,0.3,0.3"),
        wall("<scale value='5'/><translate z='5'/>", "0.6,0.6,0.6"),
        wall("<scale x='5' y='0.9'/><rotate y='1' angle='-90'/><translate x='2' y='-1.1'/>", "0.6,0.6,0.6"),
        wall("<scale x='5' y='0.9'/><rotate y='1' angle='-90'/><translate x='2' y='1.1'/>", "0.6,0.6,0.6"),
        "<shape type='rectangle'><transform name='to_world'><scale x='2' y='1'/><rotate y='1' angle='-90'/><translate x='4'/>\
         </transform><emitter type='area'><rgb name='radiance' value='40,38,30'/></emitter></shape>"
            .into(),
    ];
    scene(-1, 60.0, &medium("medium", 0.15, 0.9, HG), &room.concat())
}

#[test]
fn guided_pictures_of_fog_agree_with_unguided_ones() {
    let device = Device::new();
    let scene = foggy_room();
    let render = |device: &Device, sampler, learner, nee, seed, spp| {
        let settings = Settings { nee, learner, ..settings(&scene, [24, 24], sampler, seed) };
        Estimate::of(&device.render(&scene, &settings, spp))
    };
    let unguided = render(&device, Sampler::Bsdf, Learner::Sarsa, true, 1, if tier::is_full() { 16384 } else { 2048 });
    let spp = if tier::is_full() { 4096 } else { 512 };
    let cases = [
        (Sampler::Product, Learner::Sarsa, true),
        (Sampler::RejectionMix, Learner::MonteCarlo, true),
        (Sampler::Product, Learner::ExpectedSarsa, false),
        (Sampler::Quadtree, Learner::MonteCarlo, true),
        (Sampler::HemisphereInversion, Learner::Sarsa, true),
    ];
    for (&(sampler, learner, nee), seed) in tier::some_of(&cases, 2).iter().zip(2..) {
        let right = Comparison::new(&unguided, &render(&device, sampler, learner, nee, seed, spp), &[6, WHOLE]);
        println!("{sampler:?} {learner:?}: {right:?}");
        assert!(right.agrees(), "{sampler:?}: {right:?}");
    }
    let wrong = device.mutated(OTHER_PHASE);
    let wrong =
        Comparison::new(&unguided, &render(&wrong, Sampler::Product, Learner::Sarsa, true, 9, spp), &[6, WHOLE]);
    println!("{OTHER_PHASE}: {wrong:?}");
    assert!(!wrong.agrees(), "{OTHER_PHASE}: {wrong:?}");
}

/// A path keeps its medium in waves, too, and random numbers of a flight do not depend on how paths are traced.
#[test]
fn waves_and_one_kernel_render_the_same_bits_of_fog() {
    let device = Device::new();
    let glass = "<shape type='sphere'><float name='radius' value='0.8'/><bsdf type='dielectric'/>".to_owned()
        + &medium("interior", 4.0, 0.95, HG)
        + &medium("exterior", 0.15, 0.9, HG)
        + "</shape>";
    let mut fog = foggy_room();
    let ball = scene(-1, 60.0, "", &glass);
    // The ball's material and media follow those of the room.
    let (materials, media) = (fog.materials.len() as u32, fog.media.all.len() as u32);
    for mut material in ball.materials {
        material.boundary = material.boundary.map(|mut boundary| {
            for side in [&mut boundary.interior, &mut boundary.exterior] {
                *side = side.map(|medium| medium + media);
            }
            boundary
        });
        fog.materials.push(material);
    }
    fog.media.all.extend(ball.media.all);
    fog.primitives.extend(ball.primitives.into_iter().map(|mut primitive| {
        primitive.material += materials;
        primitive
    }));
    for sampler in [Sampler::Bsdf, Sampler::Product] {
        let render = |execution| {
            let settings = Settings { nee: true, execution, ..settings(&fog, [24, 24], sampler, 7) };
            let picture = device.render(&fog, &settings, 32);
            (picture.rgb().to_vec(), picture.albedo().to_vec(), picture.depth().to_vec())
        };
        assert!(render(Execution::Megakernel) == render(Execution::Wavefront), "{sampler:?}");
    }
}
