//! Rays through instances (`glsl/include/geometry/instance.glsl` and `traverse.glsl`), against copies.

use glam::{DMat4, DVec3, Vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::generated::kernels::NONE;
use lodestar::scene::{Camera, Primitive, PrimitiveShape, Scene};
use support::instances::{copied, transforms};
use support::statistics::Numbers;

use crate::intersections::{SHAPES, TraceInput, agreement, fault, primitives, rays, trace_raw};
use crate::surfaces::{SurfaceOutput, d3, find_in, leaving};

/// Bits of `FEATURE_TANGENTS` and `FEATURE_TEXTURES`: surfaces have texture coordinates and their derivatives.
const TANGENTS: u32 =
    lodestar::generated::constants::FEATURE_TANGENTS | lodestar::generated::constants::FEATURE_TEXTURES;

/// Flat primitives of all shapes. Some are flipped, some have vertex normals and some are met from the front only.
fn flat_primitives(count: usize, seed: u32) -> Vec<Primitive> {
    let mut numbers = Numbers::new(seed + 1);
    let mut all = primitives(&SHAPES[..3], count, seed);
    for (index, p) in all.iter_mut().enumerate() {
        (p.flip_normal, p.front_only) = (index.is_multiple_of(5), index.is_multiple_of(7));
        p.uvs = [(); 3].map(|()| [(); 2].map(|()| numbers.between(-1.0, 2.0) as f32).into());
        if p.shape == PrimitiveShape::Triangle && index.is_multiple_of(4) {
            let geometric = p.edge_u.cross(p.edge_v).normalize() * if p.flip_normal { -1.0 } else { 1.0 };
            p.normals = Some([(); 3].map(|()| (geometric + 0.5 * numbers.unit_vector().as_vec3()).normalize()));
        }
    }
    all
}

/// Primitives of all shapes in the world, and two groups that are shown by every transform, moved and scaled by `place`.
fn scene(place: impl Fn(DMat4) -> DMat4) -> Scene {
    let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], 40.0), 8, 8);
    for seed in [31, 33] {
        scene.primitives = flat_primitives(60, seed);
        let group = scene.group_from(0);
        transforms().into_iter().for_each(|(_, transform)| scene.add_instance(group, &place(transform)));
    }
    scene.primitives = primitives(&SHAPES, 200, 35);
    scene
}

/// Place of a hit among the primitives of the copied scene.
fn place(scene: &Scene, bvh: &Bvh, instance: u32, primitive: u32) -> usize {
    let source = bvh.sources[primitive as usize] as usize;
    if instance == NONE {
        return source;
    }
    let number = bvh.sources[instance as usize] as usize - scene.primitives.len();
    let length = |group: u32| scene.groups[group as usize].primitives.len();
    let group = scene.instances[number].group;
    let within = source - scene.primitives.len() - scene.instances.len() - (0..group).map(length).sum::<usize>();
    let before: usize = scene.instances[..number].iter().map(|instance| length(instance.group)).sum();
    scene.primitives.len() + before + within
}

#[test]
fn hits_are_those_of_the_twin_among_copies() {
    let scene = scene(|transform| transform);
    let bvh = Bvh::of_scene(&scene);
    let copies = copied(&scene).primitives;
    assert_eq!(bvh.instance_count(), 16);
    for any_hit in [false, true] {
        let rays = rays(8192, any_hit);
        let mut outputs = trace_raw(&bvh, bvh.depth, &rays);
        let mut shown = 0;
        for (input, output) in rays.iter().zip(&mut outputs).filter(|(_, output)| output.primitive != NONE) {
            shown += usize::from(output.instance != NONE);
            output.primitive = place(&scene, &bvh, output.instance, output.primitive) as u32;
            assert_eq!(fault(&copies, input, output), None, "{input:?} {output:?}");
        }
        let missed = rays.iter().zip(&outputs).find_map(|(input, output)| fault(&copies, input, output));
        assert_eq!(missed, None);
        assert!(shown > 1000, "{shown}");
        if !any_hit {
            let share = agreement(&copies, &rays, &outputs);
            assert!(share > 0.999, "{share}");
        }
        // The twin: copies of instances that lie elsewhere have other hits.
        let mut elsewhere = scene.clone();
        elsewhere.instances.iter_mut().for_each(|instance| instance.origin.x += 0.05);
        let elsewhere = copied(&elsewhere).primitives;
        let found = rays.iter().zip(&outputs).filter(|(input, output)| fault(&elsewhere, input, output).is_some());
        assert!(found.count() > 500);
    }
}

/// Surfaces of instances have the normals, positions, coordinates and derivatives of copies.
#[test]
fn surfaces_are_those_of_copies() {
    let scene = scene(|transform| transform);
    let (bvh, copies) = (Bvh::of_scene(&scene), copied(&scene));
    let numbered = |(index, &p): (usize, &Primitive)| Primitive { material: index as u32, ..p };
    let copies = Bvh::build(&copies.primitives.iter().enumerate().map(numbered).collect::<Vec<_>>());
    let rays = rays(8192, false);
    let pairs = find_in(&bvh, &rays, TANGENTS).into_iter().zip(find_in(&copies, &rays, TANGENTS));
    let mut compared = 0;
    for (own, copy) in pairs.filter(|(own, _)| own.primitive != NONE && own.instance != NONE) {
        if place(&scene, &bvh, own.instance, own.primitive) != copy.material as usize {
            continue;
        }
        compared += 1;
        let near = |what: &str, a: DVec3, b: DVec3, tolerance: f64| {
            assert!((a - b).length() < tolerance * (1.0 + b.length()), "{what}: {a}, not {b}");
        };
        near("position", d3(own.position), d3(copy.position), 2.0e-5);
        near("geometric normal", d3(own.geometric_normal), d3(copy.geometric_normal), 1.0e-4);
        // Normals have 16 bits per coordinate before the transform, or after it.
        near("shading normal", d3(own.shading_normal), d3(copy.shading_normal), 1.0e-3);
        near("derivative by u", d3(own.dp_du), d3(copy.dp_du), 1.0e-4);
        near("derivative by v", d3(own.dp_dv), d3(copy.dp_dv), 1.0e-4);
        near(
            "coordinates",
            Vec3::from((own.uv.into(), 0.0)).as_dvec3(),
            Vec3::from((copy.uv.into(), 0.0)).as_dvec3(),
            1.0e-3,
        );
        // The size grows with the axis that grows most. Of a vector, a matrix makes at most sqrt(3) times as much, and at least one over the
        // norm of its inverse.
        let matrix =
            scene.instances[bvh.sources[own.instance as usize] as usize - scene.primitives.len()].world_from_group();
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let growth = axes.iter().map(|axis| axis.length()).fold(0.0, f64::max);
        let inverse = matrix.inverse().to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
        let ratio = f64::from(own.size) / f64::from(copy.size);
        assert!(ratio > 0.999 / 3f64.sqrt() && ratio < 1.001 * growth * inverse, "{ratio}, {growth}, {inverse}");
        assert!(own.epsilon < 100.0 * copy.epsilon.max(1.0e-8), "{} {}", own.epsilon, copy.epsilon);
    }
    assert!(compared > 2000, "{compared}");
}

/// A ray that leaves a primitive that an instance shows never meets it again, however the instance is scaled and wherever it lies.
#[test]
fn rays_do_not_meet_what_they_leave_in_an_instance() {
    for (scale, apart) in [
        (1.0, DVec3::ZERO),
        (1.0e-4, DVec3::ZERO),
        (1.0e4, DVec3::ZERO),
        (1.0, DVec3::new(300.0, -200.0, 100.0)),
        (1.0e-4, DVec3::new(0.2, 0.3, -0.1)),
        (1.0e4, DVec3::new(1.0e7, 3.0e6, -5.0e6)),
    ] {
        let place = |transform| DMat4::from_translation(apart) * DMat4::from_scale(DVec3::splat(scale)) * transform;
        let mut scene = scene(place);
        scene.primitives.clear();
        let bvh = Bvh::of_scene(&scene);
        let placed = |ray: &TraceInput| {
            let origin = (apart + scale * d3(ray.origin)).as_vec3();
            TraceInput::new(origin, Vec3::from(ray.direction))
        };
        let rays: Vec<_> = rays(4096, false).iter().map(placed).collect();
        let surfaces = find_in(&bvh, &rays, 0);
        let hits: Vec<_> = rays.iter().zip(&surfaces).filter(|(_, o)| o.primitive != NONE).collect();
        assert!(hits.len() > 1000, "{} hits at {scale:e}", hits.len());
        let leaving: Vec<_> = hits.iter().flat_map(|(input, o)| leaving(input, o)).collect();
        let is_same = |a: &SurfaceOutput, b: &SurfaceOutput| (a.primitive, a.instance) == (b.primitive, b.instance);
        for (ray, (index, again)) in leaving.iter().zip((0..).zip(find_in(&bvh, &leaving, 0))) {
            let (_, left) = hits[index / 3];
            assert!(!is_same(left, &again), "{scale:e} {apart}: {ray:?} leaves {left:?}, meets {again:?}");
        }
    }
}
