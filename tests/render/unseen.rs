//! Shapes that the camera does not see: its rays pass them, and all other rays meet them.

use glam::{DMat4, Vec3};
use lodestar::scene::{Camera, Scene, Surface};
use lodestar::settings::{Execution, Sampler, Settings, UNLIMITED_DEPTH};
use support::panes::Pane;

use crate::closed_forms::{assert_is, mean_of};
use crate::device::Device;

const RADIANCE: f64 = 3.0;
const LAMP_RADIUS: f32 = 0.5;
/// Radiance of the walls of a round room of the radius 1 and the reflectance r about a black lamp of the radius s: r L s^2 / (1 - r (1 - s^2)).
const OF_WALLS: f64 = 0.5 * RADIANCE * 0.25 / (1.0 - 0.5 * 0.75);

type Way = (bool, Sampler, Execution);

const WAYS: [Way; 3] = [
    (true, Sampler::Bsdf, Execution::Megakernel),
    (false, Sampler::Bsdf, Execution::Wavefront),
    (true, Sampler::Product, Execution::Wavefront),
];

fn by(way: Way) -> impl Fn(&mut Settings) {
    move |s| {
        (s.nee, s.sampler, s.execution) = way;
        s.max_depth = UNLIMITED_DEPTH;
    }
}

/// A round room about a lamp, which fills the camera's picture or is invisible to it. An instance shows the lamp or none.
fn room(unseen: bool, is_instance: bool) -> Scene {
    let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 0.9], [0.0; 3], 20.0), 16, 16);
    let gray = scene.add_diffuse([0.5; 3]);
    scene.add_sphere([0.0; 3], 1.0, gray);
    let light = scene.add_light([RADIANCE as f32; 3]);
    scene.add_sphere([0.0; 3], LAMP_RADIUS, light);
    scene.primitives[1].unseen = unseen;
    if is_instance {
        let group = scene.group_from(1);
        scene.add_instance(group, &DMat4::from_rotation_y(0.3));
    }
    scene
}

/// The camera looks through the lamp at the wall behind it, which the lamp lights. It sees a lamp that does not hide.
#[test]
fn a_lamp_lights_what_the_camera_sees_through_it() {
    let device = Device::new();
    for is_instance in [false, true] {
        let seen = mean_of(&device, &room(false, is_instance), 71, 4, |_| {}).0;
        assert!((seen - RADIANCE).abs() < 1.0e-5, "instance: {is_instance}: {seen}, not {RADIANCE}");
        for (seed, way) in (72..).zip(WAYS) {
            let rendered = mean_of(&device, &room(true, is_instance), seed, 256, by(way));
            assert_is(&format!("instance: {is_instance}, {way:?}"), rendered, OF_WALLS);
        }
    }
}

/// The camera's rays are its own behind a hole, and go through the lamp there, too.
#[test]
fn holes_leave_the_camera_its_rays() {
    let device = Device::new();
    let mut scene = room(true, false);
    let material = Pane::Mask(0.0).material(&mut scene);
    scene.add_parallelogram([0.0, 0.0, 0.7], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], Surface { material, emitter: None });
    for (seed, way) in (81..).zip(WAYS) {
        let rendered = mean_of(&device, &scene, seed, 256, by(way));
        assert_is(&format!("{way:?}"), rendered, OF_WALLS);
    }
}

/// Many black sheets before a bright wall, of which the camera sees none.
#[test]
fn the_camera_sees_what_lies_behind_all_sheets() {
    let device = Device::new();
    for unseen in [false, true] {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], 20.0), 16, 16);
        let black = scene.add_diffuse([0.0; 3]);
        let light = scene.add_light([RADIANCE as f32; 3]);
        let mut add =
            |z: f32, surface: Surface| scene.add_parallelogram(Vec3::Z * z, 3.0 * Vec3::X, 3.0 * Vec3::Y, surface);
        add(-1.0, light);
        for sheet in 0..20 {
            add(0.1 * sheet as f32, black);
        }
        scene.primitives[1..].iter_mut().for_each(|sheet| sheet.unseen = unseen);
        let (mean, _) = mean_of(&device, &scene, 75, 4, |_| {});
        let expected = if unseen { RADIANCE } else { 0.0 };
        assert!((mean - expected).abs() < 1.0e-5, "unseen: {unseen}: {mean}, not {expected}");
    }
}
