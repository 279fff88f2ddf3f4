//! Pictures of meshes that change their shape, against closed forms and against pictures of still scenes.

use glam::{DMat4, Vec3, vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::scene::deformation::{Deformation, DeformedTriangle};
use lodestar::scene::{Camera, Primitive, Projection, Scene};
use lodestar::settings::{SamplePattern, Sampler, Settings};
use support::estimate::{Comparison, Estimate, WHOLE};
use support::instances::dented_ball;
use support::mutated::DEFORMING_FAULTS;
use support::scenes::{settings, steady};

use crate::device::Device;
use crate::motion::{
    SPP, assert_mean_of_still_pictures, assert_same_bits_in_all_ways, at, deviation, motion, moved, row,
};

/// A lamp of the radiance 1 that is 0.5 wide, as two triangles with their centers at these places, one after another.
fn lamp(centers: &[f32]) -> Scene {
    let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], 40.0), 16, 1);
    scene.camera.projection = Projection::Orthographic;
    let light = scene.add_light([1.0; 3]);
    let corners = |&x: &f32| [[-0.25, -2.0], [0.25, -2.0], [0.25, 2.0], [-0.25, 2.0]].map(|[u, v]| [x + u, v, 0.0]);
    let sets: Vec<Vec<[f32; 3]>> = centers.iter().map(|center| corners(center).to_vec()).collect();
    scene.add_deforming_mesh(&sets, &[[0, 1, 2], [0, 2, 3]], light);
    scene
}

/// A lamp whose vertices move evenly covers each pixel for a known share of the time.
#[test]
fn coverage_of_an_edge_whose_vertices_move() {
    let device = Device::validated();
    let two = lamp(&[-0.6, 0.5]);
    let five = lamp(&[-0.6, -0.325, -0.05, 0.225, 0.5]);
    for (what, scene) in [("two sets", &two), ("five sets", &five)] {
        let most = deviation(&row(&device, scene, &Bvh::of_scene(scene), SamplePattern::Independent), SPP);
        assert!(most < 5.0, "{what}: {most}");
    }
    // The twins: a lamp that moves less, and boxes at the shutter's opening only.
    let less = lamp(&[-0.6, 0.2]);
    assert!(deviation(&row(&device, &less, &Bvh::of_scene(&less), SamplePattern::Independent), SPP) > 10.0);
    let cut = Bvh { nodes: Bvh::of_scene(&at(&two, 0.0)).nodes, ..Bvh::of_scene(&two) };
    assert!(deviation(&row(&device, &two, &cut, SamplePattern::Independent), SPP) > 10.0);
}

/// Lets all primitives from the index `first` on deform: `place` gives a vertex and its normal at each of the times.
fn deform(scene: &mut Scene, first: usize, times: usize, place: impl Fn(usize, Vec3, Vec3) -> [Vec3; 2]) {
    let key = |p: &Primitive, time: usize| {
        let corners = [p.origin, p.origin + p.edge_u, p.origin + p.edge_v];
        let normals = p.normals.unwrap_or([Vec3::Z; 3]);
        let [a, b, c] = [0, 1, 2].map(|corner| place(time, corners[corner], normals[corner]));
        let normals = p.normals.map(|_| [a[1], b[1], c[1]].map(Vec3::normalize));
        DeformedTriangle { vertices: [a[0], b[0], c[0]], normals }
    };
    let keys: Vec<_> =
        scene.primitives[first..].iter().flat_map(|p| (0..times).map(move |time| key(p, time))).collect();
    for (primitive, keys) in scene.primitives[first..].iter_mut().zip(keys.chunks(times)) {
        let DeformedTriangle { vertices: [origin, b, c], normals } = keys[0];
        *primitive = Primitive { origin, edge_u: b - origin, edge_v: c - origin, normals, ..*primitive };
    }
    scene.deformations.push(Deformation { first: first as u32, intervals: times as u32 - 1, keys });
}

/// A dented, smooth ball that sinks and swells, a leaf that bends and flies as an instance, and a lamp that grows, in front of a wall.
fn busy() -> Scene {
    let mut scene = dented_ball();
    let swell = |time: usize, p: Vec3, n: Vec3| {
        let scale = [vec3(1.0, 1.0, 1.0), vec3(0.6, 1.5, 0.8), vec3(1.3, 0.5, 1.1)][time];
        [scale * p + [vec3(-1.5, 0.5, 0.0), vec3(-1.0, 0.0, 0.3), vec3(-0.6, -0.6, 0.0)][time], n / scale]
    };
    deform(&mut scene, 0, 3, swell);
    let gray = scene.add_diffuse([0.6, 0.5, 0.4]);
    let leaf = scene.primitives.len();
    let flat = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let bent = vec![[-0.8, -1.0, 0.6], [1.0, -1.2, 0.0], [0.7, 1.0, 0.8], [-1.0, 1.1, 0.0]];
    scene.add_deforming_mesh(&[flat.clone(), bent, flat], &[[0, 1, 2], [0, 2, 3]], gray);
    let group = scene.group_from(leaf);
    let end = moved(1.5, 1.5, 0.5) * DMat4::from_rotation_y(0.9);
    scene.add_moving_instance(group, motion(&[(0.0, moved(1.2, -0.8, 0.0)), (1.0, end)]));
    scene.add_instance(group, &(moved(0.0, 2.2, -0.5) * DMat4::from_rotation_z(0.5)));
    let lamp = scene.add_light([8.0, 6.0, 4.0]);
    let small = vec![[-0.2, 5.0, -0.2], [0.2, 5.0, -0.2], [0.2, 5.0, 0.2], [-0.2, 5.0, 0.2]];
    let large = vec![[-1.5, 5.0, -0.2], [-0.2, 5.0, -1.0], [1.5, 4.0, 0.2], [-0.2, 4.5, 1.0]];
    scene.add_deforming_mesh(&[small, large], &[[0, 1, 2], [0, 2, 3]], lamp);
    scene.add_parallelogram([0.0, 0.0, -2.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], gray);
    scene.camera = Camera::look_at([0.5, 0.3, 9.0], [0.0; 3], 45.0);
    scene
}

/// A scene that deforms is the mean of still scenes. Planted faults are found.
#[test]
fn deforming_meshes_are_the_mean_of_still_pictures() {
    assert_mean_of_still_pictures(&busy(), DEFORMING_FAULTS.into_iter().chain(["a lamp sampled at another time"]));
}

#[test]
fn the_way_of_tracing_changes_no_bit_of_deforming_meshes() {
    assert_same_bits_in_all_ways(&busy());
}

/// A mesh whose sets of vertices are equal is a mesh that stands still.
#[test]
fn equal_sets_are_a_still_mesh() {
    let device = Device::new();
    let mut still = dented_ball();
    let gray = still.add_diffuse([0.6, 0.5, 0.4]);
    still.add_parallelogram([0.0, 0.0, -2.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], gray);
    let light = still.add_light([5.0; 3]);
    still.add_parallelogram([0.0, 4.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], light);
    still.camera = Camera::look_at([0.5, 0.3, 9.0], [0.0; 3], 45.0);
    let mut deforming = still.clone();
    let wall = deforming.primitives.split_off(still.primitives.len() - 2);
    deform(&mut deforming, 0, 3, |_, p, n| [p, n]);
    deforming.primitives.extend(wall);
    let estimate = |scene: &Scene, seed| {
        let settings = Settings { nee: true, ..settings(scene, [24, 24], Sampler::Bsdf, seed) };
        Estimate::of(&device.render(scene, &steady(settings), 512))
    };
    let comparison = Comparison::new(&estimate(&still, 1), &estimate(&deforming, 2), &[1, 8, WHOLE]);
    assert!(comparison.agrees(), "{comparison:?}");
}
