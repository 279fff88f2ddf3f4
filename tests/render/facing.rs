//! Disks that face what they light: closed forms within a round room, within fog, in motion, and through holes.
//!
//! At a distance d from the center of such a disk of the radius r and the radiance L, a surface that faces the center gets the irradiance
//! pi L r^2 / (d^2 + r^2). So the walls of a round room about the lamp are evenly lit.

use glam::{Vec3, vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::radiance_map::{MappedScene, SurfacePoint};
use lodestar::scene::{Camera, LoadOptions, Scene, load};
use lodestar::settings::{Execution, Sampler, Settings, UNLIMITED_DEPTH};
use support::mutated::TURNED_TO_HOLE;
use support::panes::Pane;
use support::significance::{ALPHA, sidak, two_sided};
use support::tier;

use crate::closed_forms::{assert_is, mean_of, surprise};
use crate::device::Device;

const RADIANCE: f64 = 3.0;

/// A room of the radius 1 and the reflectance 0.5 about a lamp, which the camera in it does not see.
fn room(lamp_radius: f32) -> Scene {
    let camera = Camera { near_clip: 1.0e-4, ..Camera::look_at([0.3, 0.2, 0.1], [0.9, -0.3, 0.4], 60.0) };
    let mut scene = Scene::new(camera, 16, 16);
    let gray = scene.add_diffuse([0.5; 3]);
    scene.add_sphere([0.0; 3], 1.0, gray);
    scene.add_facing_disk([0.0; 3], lamp_radius, [RADIANCE as f32; 3]);
    scene.primitives[1].unseen = true;
    scene
}

/// Radiance of the room's walls: all reflections together double the first. The walls hide what lies beyond them.
fn of_walls(lamp_radius: f32) -> f64 {
    let squared = f64::from(lamp_radius.min(1.0)).powi(2);
    RADIANCE * squared / (1.0 + squared)
}

/// Way to find the light of a lamp: whether emitters are sampled, by which sampler, and how kernels are executed.
type Way = (bool, Sampler, Execution);

const WAYS: [Way; 5] = [
    (true, Sampler::Bsdf, Execution::Megakernel),
    (false, Sampler::Bsdf, Execution::Wavefront),
    (true, Sampler::Product, Execution::Wavefront),
    (false, Sampler::Bsdf, Execution::Megakernel),
    (true, Sampler::Product, Execution::Megakernel),
];

/// Ways that the quick tier takes.
const QUICK_WAYS: usize = 3;

/// The ways of this tier, each with a seed.
fn ways(first_seed: u32) -> impl Iterator<Item = (u32, Way)> {
    (first_seed..).zip(WAYS).take(if tier::is_full() { WAYS.len() } else { QUICK_WAYS })
}

fn by(way: Way) -> impl Fn(&mut Settings) {
    move |s| {
        (s.nee, s.sampler, s.execution) = way;
        s.max_depth = UNLIMITED_DEPTH;
    }
}

/// Also where the whole room is within the lamp's radius.
#[test]
fn a_round_room_is_evenly_lit() {
    let device = Device::new();
    for radius in [0.5, 2.0] {
        for (seed, way) in ways(41) {
            let rendered = mean_of(&device, &room(radius), seed, 256, by(way));
            assert_is(&format!("radius {radius}, {way:?}"), rendered, of_walls(radius));
        }
    }
}

/// A lamp faces the surface that it lights, also where its light passes a hole on the way.
#[test]
fn holes_do_not_turn_a_lamp() {
    let device = Device::new();
    let mut scene = room(0.5);
    let material = Pane::Mask(0.0).material(&mut scene);
    scene.add_sphere([0.3, 0.2, -0.1], 0.45, lodestar::scene::Surface { material, emitter: None });
    for (seed, way) in ways(51) {
        let rendered = mean_of(&device, &scene, seed, 512, by(way));
        assert_is(&format!("{way:?}"), rendered, of_walls(0.5));
    }
    let found = surprise(mean_of(&device.mutated(TURNED_TO_HOLE), &scene, 52, 512, by(WAYS[1])), of_walls(0.5));
    assert!(found < ALPHA, "{TURNED_TO_HOLE}: {found}");
}

/// The camera looks at a lamp that fills its picture, which it sees or not.
#[test]
fn a_lamp_hides_from_the_camera_alone() {
    let device = Device::new();
    for (unseen, expected) in [(false, RADIANCE), (true, 0.0)] {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], 10.0), 16, 16);
        scene.add_facing_disk([0.0; 3], 1.0, [RADIANCE as f32; 3]);
        scene.primitives[0].unseen = unseen;
        let (mean, _) = mean_of(&device, &scene, 61, 4, |_| {});
        assert!((mean - expected).abs() < 1.0e-5, "unseen: {unseen}: {mean}, not {expected}");
    }
}

/// The true radiance at a point has the light of a lamp that the camera does not see.
#[test]
fn the_true_radiance_has_hidden_lamps() {
    let device = Device::new();
    let point = SurfacePoint { position: vec3(0.0, -0.9, 0.0), normal: Vec3::Y };
    let brightest = |unseen: bool| {
        let mut scene = room(0.5);
        scene.primitives[1].unseen = unseen;
        let bvh = Bvh::of_scene(&scene);
        let settings = Settings { directions: 16, ..Settings::for_scene(&scene) };
        let place = MappedScene { context: device.context(), scene: &scene, bvh: &bvh };
        let radiance = place.true_radiance(&settings, &point, 4).expect("a map");
        radiance.into_iter().fold(0.0, f32::max)
    };
    assert_eq!(brightest(true), brightest(false));
    assert!(brightest(true) > 0.9 * RADIANCE as f32);
}

/// A lamp over a floor in a scene of paths of four edges.
fn lamp_over_floor(lamp: &str, body: &str) -> Scene {
    let text = format!(
        "<scene version='3.0.0'><integrator type='volpath'><integer name='max_depth' value='4'/></integrator>\
         <sensor type='perspective'><float name='fov' value='30'/><float name='shutter_open' value='0'/>\
         <float name='shutter_close' value='1'/><transform name='to_world'>\
         <lookat origin='0,2,5' target='0,0.2,0' up='0,1,0'/></transform></sensor>\
         <shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/><scale value='2'/></transform></shape>\
         <shape type='facingdisk'>{lamp}<float name='radius' value='0.6'/>\
         <boolean name='visible_to_camera' value='false'/><emitter type='area'/></shape>{body}</scene>"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, text).expect("a file");
    load(&path, &LoadOptions::default()).expect("a scene")
}

/// Light that emitter sampling finds is the light that paths find by chance, in fog, in motion, and of a second lamp behind a lamp.
#[test]
fn emitter_sampling_and_chance_find_the_same_light() {
    let device = Device::new();
    let at_rest = "<point name='center' x='0.1' y='0.5' z='0'/>";
    let moving = "<animation name='to_world'><transform time='0'><translate x='-1' y='0.5'/></transform>\
                  <transform time='1'><translate x='1' y='0.8'/></transform></animation>";
    let fog = "<shape type='cube'><transform name='to_world'><scale value='1.5'/></transform><bsdf type='null'/>\
               <medium name='interior' type='homogeneous'><float name='sigma_t' value='0.5'/>\
               <float name='albedo' value='0.8'/></medium></shape>";
    let second = "<shape type='facingdisk'><point name='center' x='-0.5' y='0.9' z='0.4'/>\
                  <float name='radius' value='0.4'/><emitter type='area'/></shape>";
    for (name, lamp, body) in [("fog", at_rest, fog), ("motion", moving, ""), ("two lamps", at_rest, second)] {
        let scene = lamp_over_floor(lamp, body);
        let with = |nee: bool, at: u32| mean_of(&device, &scene, 71 + at, 1024, |s| s.nee = nee);
        let (sampled, met) = (with(true, 0), with(false, 1));
        let equal = |factor: f64| {
            let z = (factor * sampled.0 - met.0) / sampled.1.hypot(met.1);
            sidak(two_sided(z), 16)
        };
        assert!(equal(1.0) > ALPHA, "{name}: {sampled:?}, {met:?}");
        assert!(equal(1.05) < ALPHA, "{name}: the twin, {sampled:?}, {met:?}");
    }
}
