//! Pictures of instances against pictures of copies.

use glam::{DMat4, DVec3};
use lodestar::scene::{Camera, Scene};
use lodestar::settings::{Execution, Sampler, Settings, Traversal};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::instances::{copied, dented_ball, transforms};
use support::mutated::INSTANCE_FAULTS;
use support::scenes::{ours, settings, steady};

use crate::determinism::bits;
use crate::device::Device;

const SIZE: [u32; 2] = [52, 37];

/// The Cornell box, whose two blocks are a group that a transform shows.
fn blocks(transform: DMat4) -> Scene {
    let mut scene = ours("cornell-box/scene.xml", &[]);
    // The lamp comes first.
    scene.primitives.sort_by_key(|primitive| primitive.emitter.is_none());
    let first = scene.primitives.len() - 12;
    let group = scene.group_from(first);
    scene.add_instance(group, &transform);
    scene
}

/// A dented, smooth ball, shown in nine places by transforms of all kinds in a lit box.
fn dented_balls() -> Scene {
    let mut scene = dented_ball();
    let group = scene.group_from(0);
    for (index, (_, transform)) in (0..).zip(transforms()) {
        let place = DVec3::new(2.4 * f64::from(index % 3) - 2.4, 2.4 * f64::from(index / 3) - 2.4, 0.0);
        scene.add_instance(group, &(DMat4::from_translation(place) * transform * DMat4::from_scale(DVec3::splat(0.8))));
    }
    let lamp = scene.add_light([4.0, 3.0, 2.0]);
    scene.add_parallelogram([0.0, 6.0, 1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], lamp);
    let gray = scene.add_diffuse([0.5; 3]);
    scene.add_parallelogram([0.0, 0.0, -1.5], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], gray);
    scene.camera = Camera::look_at([0.5, 0.3, 9.0], [0.0; 3], 45.0);
    scene
}

fn rendered(device: &Device, scene: &Scene, change: impl Fn(&mut Settings)) -> Vec<u32> {
    let mut settings = settings(scene, SIZE, Sampler::Bsdf, 11);
    change(&mut settings);
    bits(&device.render(scene, &steady(settings), 12))
}

/// Instances whose transform is the identity give the bits of copies, by one kernel and by waves, with and without a guide.
#[test]
fn unmoved_instances_give_the_bits_of_copies() {
    let device = Device::validated();
    let scene = blocks(DMat4::IDENTITY);
    let copies = copied(&scene);
    for (sampler, nee) in [(Sampler::Bsdf, false), (Sampler::Product, true), (Sampler::Quadtree, true)] {
        for execution in [Execution::Megakernel, Execution::Wavefront] {
            if sampler == Sampler::Quadtree && execution == Execution::Wavefront {
                continue;
            }
            let set = |s: &mut Settings| (s.sampler, s.nee, s.execution) = (sampler, nee, execution);
            let same = rendered(&device, &scene, set) == rendered(&device, &copies, set);
            assert!(same, "{sampler:?} {execution:?}");
        }
    }
    // The twin: blocks that are moved by the width of a hair have other bits.
    let moved = blocks(DMat4::from_translation(DVec3::splat(1.0e-4)));
    assert!(rendered(&device, &scene, |_| ()) != rendered(&device, &moved, |_| ()));
}

/// Waves and slices of time change no bit.
#[test]
fn the_way_of_tracing_changes_no_bit_of_instances() {
    let device = Device::validated();
    let scene = dented_balls();
    let set = |s: &mut Settings| (s.sampler, s.nee) = (Sampler::Product, true);
    let first = rendered(&device, &scene, set);
    let with = |change: &dyn Fn(&mut Settings)| {
        rendered(&device, &scene, |s| {
            set(s);
            change(s);
        })
    };
    assert!(first == with(&|s| s.execution = Execution::Wavefront), "waves");
    assert!(first == with(&|s| s.slice_milliseconds = Some(1.0)), "slices");
    assert!(first == with(&|s| s.storage_reads = true), "storage buffers");
    assert!(first != with(&|s| s.seed = 12), "another seed");
}

/// Instances and copies estimate the same picture. Normals that are turned like directions, and rays that forget by how much an instance
/// scales them, are found.
#[test]
fn instances_estimate_the_picture_of_copies() {
    let device = Device::new();
    let (scene, copies) = (dented_balls(), copied(&dented_balls()));
    let estimate = |device: &Device, scene: &Scene, sampler, seed, spp| {
        let settings = Settings { nee: true, ..settings(scene, [32, 32], sampler, seed) };
        Estimate::of(&device.render(scene, &steady(settings), spp))
    };
    let reference = estimate(&device, &copies, Sampler::Bsdf, 1, 4096);
    let agrees = |device: &Device, sampler, seed| {
        let comparison = Comparison::new(&reference, &estimate(device, &scene, sampler, seed, 1024), &[1, 8, WHOLE]);
        println!("{sampler:?}, {}: {comparison:?}", device.mutation());
        comparison.agrees()
    };
    assert!(agrees(&device, Sampler::Bsdf, 2));
    assert!(agrees(&device, Sampler::Product, 3));
    for fault in INSTANCE_FAULTS {
        assert!(!agrees(&device.mutated(fault), Sampler::Bsdf, 2), "{fault}");
    }
}

/// Ray queries do not trace instances, and say so.
#[test]
fn ray_queries_refuse_instances() {
    let device = Device::new();
    let scene = blocks(DMat4::IDENTITY);
    let settings = Settings { traversal: Traversal::Query, ..settings(&scene, SIZE, Sampler::Bsdf, 1) };
    let error = device.refusal(&scene, &settings);
    assert_eq!(
        error,
        "--traversal query does not trace instances, of which the scene keeps 1: take --traversal compute"
    );
}
