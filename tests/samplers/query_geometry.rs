//! Elements of acceleration structures for ray queries (`src/encode/query_geometry.rs`).

use glam::{DVec3, Vec3, vec3};
use lodestar::encode::bvh::Bvh;
use lodestar::encode::query_geometry::{MARGIN, QueryGeometry};
use lodestar::generated::kernels::PRIMITIVE_FRONT_ONLY;
use lodestar::scene::{Primitive, PrimitiveShape};
use support::primitives::primitive;

fn geometry(primitives: &[Primitive]) -> (Bvh, QueryGeometry) {
    let bvh = Bvh::build(primitives);
    let geometry = QueryGeometry::new(&bvh, vec3(5.5, 0.5, 2.0), MARGIN);
    (bvh, geometry)
}

/// Distance of a point from the line of an edge, positive on the side of the triangle's interior.
fn inside(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    normal.cross(b - a).normalize().dot(point - a)
}

#[test]
fn edges_lie_outside_by_the_margin() {
    let corner = vec3(5.1, 0.2, 0.3);
    let (_, geometry) =
        geometry(&[primitive(PrimitiveShape::Triangle, corner, vec3(1.0, 0.1, 0.0), vec3(0.3, 0.8, 0.4))]);
    assert_eq!((geometry.opaque.len(), geometry.boxes.len()), (1, 0));
    let grown = geometry.opaque[0].map(|corner| Vec3::from(corner).as_dvec3());
    let own = [corner, corner + vec3(1.0, 0.1, 0.0), corner + vec3(0.3, 0.8, 0.4)].map(Vec3::as_dvec3);
    for by in 0..3 {
        let (mut grown, mut own) = (grown, own);
        // The hierarchy may begin the triangle at another corner.
        let begin = (0..3).min_by(|&a, &b| own[0].distance(grown[a]).total_cmp(&own[0].distance(grown[b]))).unwrap();
        grown.rotate_left(begin);
        grown.rotate_left(by);
        own.rotate_left(by);
        let margin = inside(own[0], grown);
        assert!(margin > 0.9e-6 && margin < 2.0e-5, "{margin}");
    }
}

#[test]
fn every_shape_has_its_elements() {
    let (u, v) = (vec3(0.5, 0.0, 0.0), vec3(0.0, 0.5, 0.0));
    let shape = |shape, x: f32| primitive(shape, vec3(5.0 + x, 3.0, 0.0), u, v);
    let front = Primitive { front_only: true, ..shape(PrimitiveShape::Triangle, 1.0) };
    let needle = primitive(PrimitiveShape::Triangle, 5.0 * Vec3::ONE, u, u + 1.0e-7 * v);
    let point = primitive(PrimitiveShape::Triangle, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
    let all = [
        shape(PrimitiveShape::Triangle, 0.0),
        shape(PrimitiveShape::Parallelogram, 2.0),
        shape(PrimitiveShape::Disk, 4.0),
        shape(PrimitiveShape::Sphere, 6.0),
        front,
        needle,
        point,
    ];
    let (bvh, geometry) = geometry(&all);
    assert_eq!((geometry.opaque.len(), geometry.front_only.len(), geometry.boxes.len()), (3, 1, 4));
    assert_eq!(geometry.elements[..3], [3, 6, 7]);
    assert_eq!(geometry.elements.len(), 3 + 8);
    let flags = |element: u32| bvh.primitives[element as usize].flags;
    assert!(flags(geometry.elements[6]) & PRIMITIVE_FRONT_ONLY != 0);
    let mut sources: Vec<_> = geometry.elements[3..].iter().map(|&index| bvh.sources[index as usize]).collect();
    sources.sort_unstable();
    assert_eq!(sources, [0, 1, 1, 2, 3, 4, 5, 6]);
    assert_eq!(QueryGeometry::most_elements(&bvh), 8);
    assert!(geometry.boxes.iter().all(|[low, high]| low.iter().zip(high).all(|(low, high)| low < high)));
}

#[test]
fn nothing_has_no_element() {
    let (_, geometry) = geometry(&[]);
    assert_eq!(geometry.elements, [3, 3, 3]);
}

/// A triangle with several boxes in the hierarchy is one element, and one that is huge beside the others is a box.
#[test]
fn split_triangles_occur_once_and_huge_ones_are_boxes() {
    let small = |i: usize| {
        let at = vec3(5.0 + 0.01 * i as f32, 0.5, 0.0);
        primitive(PrimitiveShape::Triangle, at, vec3(0.01, 0.0, 0.0), vec3(0.0, 0.01, 0.0))
    };
    let mut all: Vec<_> = (0..100).map(small).collect();
    all.push(primitive(PrimitiveShape::Triangle, 5.0 * Vec3::X, vec3(3.0, 3.0, 3.0), vec3(3.0, 3.1, 3.0)));
    let (bvh, geometry) = geometry(&all);
    assert!(bvh.primitives.len() > all.len(), "no triangle was split");
    assert_eq!((geometry.opaque.len(), geometry.boxes.len()), (101, 0));
    all.push(primitive(PrimitiveShape::Triangle, Vec3::ZERO, 1.0e5 * Vec3::X, 1.0e5 * Vec3::Z));
    let huge = primitive(PrimitiveShape::Parallelogram, Vec3::ZERO, 2.0e38 * Vec3::X, 2.0e38 * Vec3::Z);
    all.push(huge);
    let (_, geometry) = self::geometry(&all);
    assert_eq!((geometry.opaque.len(), geometry.boxes.len()), (101, 3));
    assert!(geometry.boxes.iter().flatten().flatten().all(|coordinate| coordinate.is_finite()));
}
