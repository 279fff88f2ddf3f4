//! Ray queries of the device (`glsl/include/geometry/ray_query.glsl`) against the traversal in compute.

use glam::{EulerRot, Quat, Vec3, vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::encode::query_geometry::{MARGIN, QueryGeometry};
use lodestar::generated::kernels::{NONE, Variant, test};
use lodestar::gpu::{Buffer, StructurePart};
use lodestar::scene::{Primitive, PrimitiveShape};
use support::device::Device;
use support::primitives::primitive;
use support::statistics::Numbers;

use crate::intersections::{SHAPES, TraceInput, TraceOutput, build, primitives, rays, trace_with_stack};

/// Hits in a hierarchy that ray queries find in an acceleration structure of `geometry`.
fn trace_by_query(device: &Device, bvh: &Bvh, geometry: &QueryGeometry, rays: &[TraceInput]) -> Vec<TraceOutput> {
    let parts = [
        StructurePart::OpaqueTriangles(&geometry.opaque),
        StructurePart::Triangles(&geometry.front_only),
        StructurePart::Boxes(&geometry.boxes),
    ];
    let structure = Buffer::acceleration_structure(&device.context, "test", &parts).expect("a structure");
    let records = device.uploaded("primitives", &bvh.primitives);
    let attributes = device.uploaded("attributes", &bvh.attributes);
    let elements = device.uploaded("elements", &geometry.elements);
    let variant =
        Variant { has_spheres: bvh.has_spheres(), has_front_only: bvh.has_front_only(), ..Variant::default() };
    let mut found: Vec<TraceOutput> =
        device.map_with(&test::TRAVERSE_BY_QUERY, &variant, rays, &[&records, &attributes, &structure, &elements]);
    for output in found.iter_mut().filter(|output| output.primitive != NONE) {
        output.primitive = bvh.attributes[output.primitive as usize].material;
    }
    found
}

fn geometry(bvh: &Bvh) -> QueryGeometry {
    QueryGeometry::new(bvh, 3.0 * Vec3::ONE, MARGIN)
}

/// Share of the distance by which two hits differ between which rounding decides.
const TIE: f32 = 1.0e-6;

/// Numbers of rays whose hits differ: by at most `tie` of the distance, and by more.
fn differing(rays: &[TraceInput], ours: &[TraceOutput], theirs: &[TraceOutput], tie: f32) -> (usize, usize) {
    let bits = |hit: &TraceOutput| (hit.t.to_bits(), hit.uv.map(f32::to_bits), hit.primitive);
    let mut counts = (0, 0);
    for ((ray, ours), theirs) in rays.iter().zip(ours).zip(theirs) {
        let is_equal = match ray.any_hit {
            0 => bits(ours) == bits(theirs),
            _ => (ours.primitive == NONE) == (theirs.primitive == NONE),
        };
        let is_tie = ray.any_hit == 0 && (ours.t - theirs.t).abs() <= tie * (1.0 + ours.t);
        match (is_equal, is_tie) {
            (true, _) => {}
            (false, true) => counts.0 += 1,
            (false, false) => counts.1 += 1,
        }
    }
    counts
}

/// All shapes, a third of them met from the front only.
fn mixed() -> Vec<Primitive> {
    let mut primitives = primitives(&SHAPES, 2000, 91);
    for (index, p) in primitives.iter_mut().enumerate() {
        (p.front_only, p.flip_normal) = (index.is_multiple_of(3), (index / SHAPES.len()).is_multiple_of(2));
    }
    primitives
}

/// Hits have the bits of the traversal in compute. An acceleration structure of other primitives is found.
#[test]
fn hits_are_those_of_the_traversal_in_compute() {
    let device = Device::new();
    if !device.has_ray_queries("hits_are_those_of_the_traversal_in_compute") {
        return;
    }
    let primitives = mixed();
    let bvh = build(&primitives);
    let moved: Vec<_> = primitives.iter().map(|&p| Primitive { origin: p.origin + 0.03 * Vec3::X, ..p }).collect();
    for any_hit in [false, true] {
        let rays = rays(1 << 16, any_hit);
        let ours = trace_with_stack(&bvh, bvh.depth, &rays);
        let differing =
            |geometry: &QueryGeometry| differing(&rays, &ours, &trace_by_query(&device, &bvh, geometry, &rays), TIE);
        let counts = differing(&geometry(&bvh));
        println!("any hit {any_hit}: {} of {} rays differ by a tie, {} otherwise", counts.0, rays.len(), counts.1);
        assert!(counts.0 <= 3 && counts.1 == 0, "{counts:?}");
        let twin = differing(&geometry(&build(&moved)));
        assert!(twin.1 > 20, "{twin:?}");
    }
}

fn turn() -> Quat {
    Quat::from_euler(EulerRot::XYZ, 0.3, 0.7, 1.1)
}

/// Closed mesh of a rotated cube around the origin with 12 n^2 triangles, whose shared corners are rounded apart.
fn cube(n: u32) -> Vec<Primitive> {
    let turn = turn();
    let at = |i: u32| 2.0 * i as f32 / n as f32 - 1.0;
    let mut triangles = Vec::new();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        let point = |i, j| {
            let mut point = Vec3::ZERO;
            (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (side, at(i), at(j));
            turn * point
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                triangles.push(primitive(PrimitiveShape::Triangle, a, b - a, c - a));
            }
        }
    }
    triangles
}

/// Rays from within the cube towards points on the edges of its triangles.
fn rays_at_edges(triangles: &[Primitive], count: usize) -> Vec<TraceInput> {
    let mut numbers = Numbers::new(92);
    let mut ray = |index: usize| {
        let p = &triangles[index % triangles.len()];
        let along = numbers.between(0.0, 1.0) as f32;
        let origin = 0.5 * (numbers.unit_vector() * numbers.between(0.0, 1.0)).as_vec3();
        TraceInput::new(origin, (p.origin + along * p.edge_u - origin).normalize())
    };
    (0..count).map(&mut ray).collect()
}

/// No ray passes between two triangles of a closed mesh. Without the margin, rays do.
#[test]
fn no_ray_passes_between_triangles() {
    let device = Device::new();
    if !device.has_ray_queries("no_ray_passes_between_triangles") {
        return;
    }
    let triangles = cube(40);
    let (bvh, rays) = (build(&triangles), rays_at_edges(&triangles, 1 << 20));
    let missed = |margin: f64| {
        let geometry = QueryGeometry::new(&bvh, vec3(0.1, 0.2, 0.3), margin);
        let hits = trace_by_query(&device, &bvh, &geometry, &rays);
        hits.iter().filter(|hit| hit.primitive == NONE).count()
    };
    let counts = [MARGIN, 0.0].map(missed);
    println!("{} of {} rays passed, {} without the margin", counts[0], rays.len(), counts[1]);
    assert_eq!(counts[0], 0);
    assert!(counts[1] > 0);
}

/// Rays from the walls of a room meet a trinket before the camera, a mesh ten thousand times smaller than the room, as they do in
/// compute. Rays that begin just off a surface meet what they meet in compute, too.
#[test]
fn rays_from_afar_and_rays_that_leave_surfaces_meet_the_same() {
    let device = Device::new();
    if !device.has_ray_queries("rays_from_afar_and_rays_that_leave_surfaces_meet_the_same") {
        return;
    }
    let scaled = |p: &Primitive, by: f32| Primitive {
        origin: by * p.origin,
        edge_u: by * p.edge_u,
        edge_v: by * p.edge_v,
        ..*p
    };
    let trinket: Vec<_> = cube(24).iter().map(|p| scaled(p, 1.0e-3)).collect();
    let room = cube(1);
    let all: Vec<_> = trinket.iter().copied().chain(room.iter().map(|p| scaled(p, 10.0))).collect();
    let bvh = build(&all);
    let mut numbers = Numbers::new(94);
    let mut from_afar = |index: usize| {
        let p = &trinket[index % trinket.len()];
        let along = numbers.between(0.0, 1.0) as f32;
        let origin = (numbers.unit_vector() * numbers.between(1.0, 9.0)).as_vec3();
        let target = p.origin + along * p.edge_u;
        // Near the cube's own edges, rounding decides between the cube and the wall behind it.
        let face = turn().inverse() * target / 1.0e-3;
        let is_within = face.abs().to_array().iter().filter(|coordinate| **coordinate > 0.9).count() == 1;
        let direction = (target - origin).normalize();
        let is_steep = direction.dot(p.edge_u.cross(p.edge_v).normalize()).abs() > 0.2;
        (is_within && is_steep).then(|| TraceInput::new(origin, direction))
    };
    let mut rays: Vec<_> = (0..1 << 18).filter_map(&mut from_afar).collect();
    let hits = trace_with_stack(&bvh, bvh.depth, &rays);
    let leaving = rays.iter().zip(&hits).filter(|(_, hit)| hit.primitive != NONE).map(|(ray, hit)| {
        let [origin, direction] = [ray.origin, ray.direction].map(Vec3::from);
        let way = numbers.unit_vector().as_vec3();
        TraceInput::new(origin + hit.t * (1.0 - 1.0e-6) * direction, if way.dot(direction) < 0.0 { way } else { -way })
    });
    let leaving: Vec<_> = leaving.collect();
    rays.extend(leaving);
    let ours = trace_with_stack(&bvh, bvh.depth, &rays);
    // Where a ray from afar hits a face errs by roundings of the way, over the cosine of incidence.
    let counts = |margin: f64| {
        let geometry = QueryGeometry::new(&bvh, 4.0e-3 * Vec3::ONE, margin);
        differing(&rays, &ours, &trace_by_query(&device, &bvh, &geometry, &rays), 10.0 * TIE)
    };
    let (counts, without) = (counts(MARGIN), counts(0.0));
    println!(
        "{} of {} rays differ by a tie, {} otherwise; {} without the margin",
        counts.0,
        rays.len(),
        counts.1,
        without.1
    );
    assert!(ours.iter().filter(|hit| hit.primitive != NONE).count() > rays.len() / 2);
    assert!(counts.1 == 0 && without.1 > 0, "{counts:?}, {without:?} without the margin");
}

/// Structures without any element, of needles that become boxes, and of primitives without area.
#[test]
fn nothing_needles_and_points_do_no_harm() {
    let device = Device::new();
    if !device.has_ray_queries("nothing_needles_and_points_do_no_harm") {
        return;
    }
    let needle = |i: usize| {
        let at = vec3(0.01 * i as f32, 0.0, 0.0);
        primitive(PrimitiveShape::Triangle, at, vec3(1.0e-7, 0.0, 0.0), vec3(0.0, 1.0, 0.2))
    };
    let points = primitives(&[PrimitiveShape::Triangle], 50, 93);
    let points = points.into_iter().map(|p| Primitive { edge_u: Vec3::ZERO, edge_v: Vec3::ZERO, ..p }).collect();
    for primitives in [Vec::new(), (0..100).map(needle).collect(), points] {
        let bvh = build(&primitives);
        let mut rays = rays(4096, false);
        rays.extend(rays_at_edges(&primitives, if primitives.is_empty() { 0 } else { 4096 }));
        rays.retain(|ray| Vec3::from(ray.direction).is_finite());
        let ours = trace_with_stack(&bvh, bvh.depth, &rays);
        let counts = differing(&rays, &ours, &trace_by_query(&device, &bvh, &geometry(&bvh), &rays), TIE);
        assert_eq!(counts, (0, 0), "{} primitives", primitives.len());
    }
}
