//! Pictures of scenes that move, against closed forms and against pictures of still scenes.

use glam::{DMat4, DVec3};
use lodestar::encode::bvh::Bvh;
use lodestar::image::Image;
use lodestar::scene::deformation::Deformation;
use lodestar::scene::{Camera, Course, Instance, Motion, Primitive, Projection, Scene};
use lodestar::settings::{Execution, SamplePattern, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::instances::{copied, dented_ball};
use support::mutated::{self, INSTANCE_FAULTS, MOTION_FAULTS};
use support::scenes::{ours, settings, steady};
use support::tier;

use crate::determinism::bits;
use crate::device::{Device, steps};

pub fn motion(keys: &[(f64, DMat4)]) -> Motion {
    match Motion::of_keys(keys, [0.0, 1.0]) {
        Ok(Course::Moving(motion)) => motion,
        other => panic!("{other:?}"),
    }
}

pub fn moved(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

/// An orthographic camera that sees x from -1 to 1 in a row of pixels, and a lamp of the radiance 1 that is 0.5 wide.
pub fn edge(lamp: Option<Motion>, camera: Option<Motion>) -> Scene {
    let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], 40.0), 16, 1);
    scene.camera.projection = Projection::Orthographic;
    let light = scene.add_light([1.0; 3]);
    scene.add_parallelogram([0.0; 3], [0.25, 0.0, 0.0], [0.0, 2.0, 0.0], light);
    if let Some(motion) = lamp {
        let group = scene.group_from(0);
        scene.add_moving_instance(group, motion);
    }
    if let Some(motion) = camera {
        scene.move_camera(motion);
    }
    scene
}

/// Share of time in which a lamp from -0.25 to 0.25, whose center goes evenly from -0.6 to 0.5, covers x; means over pixels.
fn coverage(pixel: u32) -> f64 {
    let at = |x: f64| {
        let (enters, leaves) = ((x - 0.25 + 0.6) / 1.1, (x + 0.25 + 0.6) / 1.1);
        (leaves.min(1.0) - enters.max(0.0)).max(0.0)
    };
    let place = |i: u32| -1.0 + (f64::from(pixel) + (f64::from(i) + 0.5) / 1000.0) / 8.0;
    (0..1000).map(|i| at(place(i))).sum::<f64>() / 1000.0
}

/// Largest deviation of a row of pixels from the closed form, in standard deviations.
pub fn deviation(image: &Image, spp: u32) -> f64 {
    let of = |(pixel, value): (u32, &[f32; 3])| {
        let expected = coverage(pixel);
        // Each sample is 0 or 1.
        let deviation = (expected * (1.0 - expected) / f64::from(spp)).sqrt().max(1.0e-4);
        (f64::from(value[0]) - expected).abs() / deviation
    };
    (0..).zip(&image.pixels).map(of).fold(0.0, f64::max)
}

pub const SPP: u32 = 1024;

pub fn row(device: &Device, scene: &Scene, bvh: &Bvh, pattern: SamplePattern) -> Image {
    let settings = Settings { pattern, ..settings(scene, [16, 1], Sampler::Bsdf, 5) };
    let mut renderer = mutated::renderer(device.context(), scene, bvh, &settings, None);
    steps(&mut renderer, &settings, SPP);
    renderer.picture().expect("a picture").image()
}

/// A lamp that moves evenly covers each pixel for a known share of the time, and so does a lamp that stands before a camera which moves
/// the other way. A box at the shutter's opening only cuts the lamp off.
#[test]
fn coverage_of_a_moving_edge() {
    let device = Device::validated();
    // Patterns make samples even, so that they deviate less.
    for pattern in [SamplePattern::Independent, SamplePattern::Sobol, SamplePattern::BlueNoise] {
        let lamp = edge(Some(motion(&[(0.0, moved(-0.6, 0.0, 0.0)), (1.0, moved(0.5, 0.0, 0.0))])), None);
        let still = edge(None, None);
        let from = still.camera.world_from_camera.as_dmat4();
        let keys = [(0.0, moved(0.6, 0.0, 0.0) * from), (1.0, moved(-0.5, 0.0, 0.0) * from)];
        let camera = edge(None, Some(motion(&keys)));
        // Three keys on the way change nothing.
        let keys = [(0.0, moved(-0.6, 0.0, 0.0)), (0.3, moved(-0.27, 0.0, 0.0)), (1.0, moved(0.5, 0.0, 0.0))];
        let by_keys = edge(Some(motion(&keys)), None);
        for (what, scene) in [("lamp", &lamp), ("camera", &camera), ("three keys", &by_keys)] {
            let most = deviation(&row(&device, scene, &Bvh::of_scene(scene), pattern), SPP);
            assert!(most < 5.0, "{what}, {pattern:?}: {most}");
        }
        // The twins: a lamp that stands, and a box at the shutter's opening only.
        assert!(deviation(&row(&device, &still, &Bvh::of_scene(&still), pattern), SPP) > 20.0);
        let opening = at(&lamp, 0.0);
        let nodes = Bvh::of_scene(&opening).nodes;
        let cut = Bvh { nodes, ..Bvh::of_scene(&lamp) };
        let most = deviation(&row(&device, &lamp, &cut, pattern), SPP);
        assert!(most > 10.0, "{most}");
    }
}

/// Moves the vertices of triangles that deform to where they are at a time, for ever.
fn deform(primitives: &mut [Primitive], deformations: &mut Vec<Deformation>, time: f64) {
    for deformation in deformations.drain(..) {
        for index in deformation.triangles() {
            let place = time * f64::from(deformation.intervals);
            let before = (place as usize).min(deformation.intervals as usize - 1);
            let keys = &deformation.keys_of(index)[before..];
            let (before, after, way) = (keys[0], keys[1], (place - before as f64) as f32);
            let normals = before.normals.zip(after.normals);
            let [a, b, c] = [0, 1, 2].map(|at| before.vertices[at].lerp(after.vertices[at], way));
            primitives[index as usize] = Primitive {
                origin: a,
                edge_u: b - a,
                edge_v: c - a,
                normals: normals.map(|(a, b)| [0, 1, 2].map(|corner| a[corner].lerp(b[corner], way).normalize())),
                ..primitives[index as usize]
            };
        }
    }
}

/// The scene as it stands at a time.
pub fn at(scene: &Scene, time: f64) -> Scene {
    let mut still = scene.clone();
    deform(&mut still.primitives, &mut still.deformations, time);
    still.groups.iter_mut().for_each(|group| deform(&mut group.primitives, &mut group.deformations, time));
    for instance in &mut still.instances {
        if let Some(motion) = instance.motion {
            *instance = Instance::new(instance.group, &scene.motions[motion as usize].at(time));
        }
    }
    still.motions.clear();
    if let Some(motion) = still.camera_motion.take() {
        still.camera.world_from_camera = motion.at(time).as_mat4();
    }
    still
}

/// A dented, smooth ball that turns and grows, a smooth sphere that flies, and a lamp that swings, in front of a wall and seen by a
/// camera that moves.
fn busy() -> Scene {
    let mut scene = dented_ball();
    let ball = scene.group_from(0);
    let turned = moved(-1.0, 1.0, 0.5) * DMat4::from_rotation_y(2.0) * DMat4::from_scale(DVec3::new(1.4, 0.6, 1.0));
    let last = moved(-0.5, -0.5, 0.0) * DMat4::from_rotation_x(1.5) * DMat4::from_scale(DVec3::splat(0.8));
    scene.add_moving_instance(ball, motion(&[(0.0, moved(-2.0, 0.0, 0.0)), (0.4, turned), (1.0, last)]));
    let gray = scene.add_diffuse([0.6, 0.5, 0.4]);
    scene.add_sphere([0.2, 0.0, 0.0], 0.8, gray);
    let sphere = scene.group_from(0);
    let grown = moved(1.0, 2.0, 0.5) * DMat4::from_scale(DVec3::splat(1.3));
    scene.add_moving_instance(sphere, motion(&[(0.0, moved(1.5, -1.0, 0.0)), (1.0, grown)]));
    let lamp = scene.add_light([8.0, 6.0, 4.0]);
    scene.add_parallelogram([0.0, 5.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], lamp);
    let swinging = scene.group_from(0);
    let end = moved(0.0, 0.0, 1.0) * DMat4::from_rotation_z(1.0);
    scene.add_moving_instance(swinging, motion(&[(0.0, DMat4::from_rotation_z(-0.8)), (1.0, end)]));
    scene.add_parallelogram([0.0, 0.0, -2.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], gray);
    scene.camera = Camera::look_at([0.5, 0.3, 9.0], [0.0; 3], 45.0);
    let eye = scene.camera.world_from_camera.as_dmat4();
    scene.move_camera(motion(&[(0.0, eye), (1.0, moved(0.3, 0.0, -0.5) * eye * DMat4::from_rotation_y(0.05))]));
    scene
}

/// Mean of pictures at so many times, in the middles of equal parts of the shutter's time.
fn averaged(device: &Device, scene: &Scene, size: [u32; 2], times: u32, spp: u32) -> Estimate {
    let pixels = (size[0] * size[1]) as usize;
    let (mut mean, mut variance) = (vec![[0.0_f64; 3]; pixels], vec![[0.0_f64; 3]; pixels]);
    for part in 0..times {
        let still = at(scene, (f64::from(part) + 0.5) / f64::from(times));
        let settings = Settings { nee: true, ..settings(&still, size, Sampler::Bsdf, 100 + part) };
        let picture = device.render(&still, &steady(settings), spp);
        let add = |sums: &mut Vec<[f64; 3]>, image: Image, share: f64| {
            for (sum, value) in sums.iter_mut().flatten().zip(image.pixels.iter().flatten()) {
                *sum += f64::from(*value) * share;
            }
        };
        add(&mut mean, picture.image(), 1.0 / f64::from(times));
        add(&mut variance, picture.variance_image(), 1.0 / f64::from(times).powi(2));
    }
    let image = |of: &[[f64; 3]]| Image {
        width: size[0],
        height: size[1],
        pixels: of.iter().map(|pixel| pixel.map(|x| x as f32)).collect(),
    };
    Estimate::new(&image(&mean), &image(&variance))
}

/// Checks that a scene that moves is the mean of still scenes, with and without a guide, and that faults are found. The quick tier takes
/// few times, at which single pixels at edges differ.
pub fn assert_mean_of_still_pictures(scene: &Scene, faults: impl IntoIterator<Item = &'static str>) {
    let device = Device::new();
    let size = [24, 24];
    let (times, sides): (_, &[usize]) = if tier::is_full() { (64, &[1, 8, WHOLE]) } else { (16, &[8, WHOLE]) };
    let reference = averaged(&device, scene, size, times, 4096 / times);
    let agrees = |device: &Device, sampler, seed, nee| {
        let settings = Settings { nee, ..settings(scene, size, sampler, seed) };
        let found = Estimate::of(&device.render(scene, &steady(settings), 1024));
        let comparison = Comparison::new(&reference, &found, sides);
        println!("{sampler:?}, {}: {comparison:?}", device.mutation());
        comparison.agrees()
    };
    assert!(agrees(&device, Sampler::Bsdf, 2, true));
    assert!(agrees(&device, Sampler::Bsdf, 3, false));
    assert!(agrees(&device, Sampler::Product, 4, true));
    for fault in faults {
        assert!(!agrees(&device.mutated(fault), Sampler::Bsdf, 2, true), "{fault}");
    }
}

#[test]
fn motion_is_the_mean_of_still_pictures() {
    // Things stand too far from each other here for wrong lengths of rays to change what is nearest. `render instances` finds that fault.
    let of_normals = INSTANCE_FAULTS.into_iter().filter(|fault| fault.contains("normals"));
    assert_mean_of_still_pictures(&busy(), MOTION_FAULTS.into_iter().chain(of_normals));
}

/// Checks that waves, slices of time and storage buffers change no bit.
pub fn assert_same_bits_in_all_ways(scene: &Scene) {
    let device = Device::validated();
    let rendered = |change: &dyn Fn(&mut Settings)| {
        let mut settings = settings(scene, [40, 30], Sampler::Product, 11);
        settings.nee = true;
        change(&mut settings);
        bits(&device.render(scene, &steady(settings), 12))
    };
    let first = rendered(&|_| ());
    assert!(first == rendered(&|s| s.execution = Execution::Wavefront), "waves");
    assert!(first == rendered(&|s| s.slice_milliseconds = Some(1.0)), "slices");
    assert!(first == rendered(&|s| s.storage_reads = true), "storage buffers");
    assert!(first != rendered(&|s| s.seed = 12), "another seed");
}

#[test]
fn the_way_of_tracing_changes_no_bit_of_motion() {
    assert_same_bits_in_all_ways(&busy());
}

/// Lamps that instances show light a scene as lamps of the scene itself do, with all ways to draw lights.
#[test]
fn lamps_in_instances_light_like_copies() {
    let device = Device::new();
    let mut scene = Scene::new(Camera::look_at([0.0, 1.0, 9.0], [0.0; 3], 45.0), 24, 24);
    let lamp = scene.add_light([8.0, 6.0, 4.0]);
    scene.add_parallelogram([0.0; 3], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4], lamp);
    scene.add_mesh(&[[0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 0.5]], &[[0, 1, 2]], lamp);
    let group = scene.group_from(0);
    for (index, scale) in [(-1.0, 1.0), (0.0, 0.5), (1.0, 2.0)] {
        let place = moved(2.0 * index, 2.5, 0.0) * DMat4::from_rotation_z(0.4 * index);
        scene.add_instance(group, &(place * DMat4::from_scale(DVec3::new(scale, 1.0, 1.0))));
    }
    let other = scene.add_light([1.0, 2.0, 3.0]);
    scene.add_parallelogram([0.0, 3.0, 2.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.5], other);
    let gray = scene.add_diffuse([0.5; 3]);
    scene.add_parallelogram([0.0, -1.0, 0.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0], gray);
    scene.add_parallelogram([0.0, 0.0, -3.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], gray);
    let copies = copied(&scene);
    let estimate = |scene: &Scene, sampler, seed| {
        let settings = Settings { nee: true, ..settings(scene, [24, 24], sampler, seed) };
        Estimate::of(&device.render(scene, &steady(settings), 1024))
    };
    let reference = estimate(&copies, Sampler::Bsdf, 1);
    for (seed, sampler) in [(2, Sampler::Bsdf), (3, Sampler::Product), (4, Sampler::RejectionMix)] {
        let comparison = Comparison::new(&reference, &estimate(&scene, sampler, seed), &[1, 8, WHOLE]);
        println!("{sampler:?}: {comparison:?}");
        assert!(comparison.agrees(), "{sampler:?}");
    }
    // The twin: a lamp that is a little larger.
    scene.instances[0].axes[0] *= 1.1;
    let comparison = Comparison::new(&reference, &estimate(&scene, Sampler::Bsdf, 5), &[1, 8, WHOLE]);
    assert!(!comparison.agrees(), "{comparison:?}");
}

/// Without emitter sampling, instances of lamps whose transform is the identity give the bits of copies.
#[test]
fn unmoved_lamps_give_the_bits_of_copies() {
    let device = Device::new();
    let mut scene = ours("cornell-box/scene.xml", &[]);
    let group = scene.group_from(0);
    scene.add_instance(group, &DMat4::IDENTITY);
    let copies = copied(&scene);
    let rendered = |scene: &Scene| bits(&device.render(scene, &settings(scene, [32, 32], Sampler::Product, 7), 8));
    assert!(rendered(&scene) == rendered(&copies));
}

/// The depth of a wall, as a camera sees it that moves away from it, is that of the middle of the time.
#[test]
fn depths_are_those_of_the_moving_camera() {
    let device = Device::new();
    let mut scene = edge(None, None);
    let gray = scene.add_diffuse([0.5; 3]);
    scene.add_parallelogram([0.0, 0.0, -1.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], gray);
    let from = scene.camera.world_from_camera.as_dmat4();
    scene.move_camera(motion(&[(0.0, from), (1.0, moved(0.0, 0.0, 2.0) * from)]));
    let picture = device.render(&scene, &settings(&scene, [16, 1], Sampler::Bsdf, 3), 4096);
    let depth = picture.depth()[0];
    assert!((depth - 7.0).abs() < 0.1, "{depth}");
}
