//! Maps of directions: `glsl/include/math/direction_map.glsl`, `equal_area.glsl` and `cylindrical.glsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec2, Vec3, dvec2, vec2, vec3};
use lodestar::generated::kernels::{Variant, test};
use lodestar::math::direction_map::{bin_center, map_to_sphere};
use lodestar::settings::DirectionMap;
use support::device::Device;
use support::statistics::Numbers;
use support::twins::direction_map as twin;
use support::twins::equal_area::square_bin;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct MapInput {
    p: [f32; 2],
    w: [f32; 3],
    bin: u32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct MapOutput {
    w_of_p: [f32; 3],
    p_of_w: [f32; 2],
    antipode_of_p: [f32; 2],
    w_of_antipode: [f32; 3],
    p_of_w_of_p: [f32; 2],
    center: [f32; 3],
    bin_of_p: u32,
    bin_of_w: u32,
    bin_of_center: u32,
}

fn d3(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

fn d2(v: [f32; 2]) -> DVec2 {
    Vec2::from(v).as_dvec2()
}

const SIDE: u32 = 256;
const MAPS: [DirectionMap; 2] = [DirectionMap::EqualArea, DirectionMap::Cylindrical];

fn variant(map: DirectionMap, resolution: u32) -> Variant {
    Variant { map: map as u32, direction_resolution: resolution, ..Variant::default() }
}

/// Points of a grid over the square, including its border, corners, diagonals and center.
fn points() -> Vec<Vec2> {
    let at = |i: u32| 2.0 * i as f32 / SIDE as f32 - 1.0;
    (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| vec2(at(x), at(y)))).collect()
}

/// Random directions, and special ones: poles, axes, zeros of either sign, and directions next to poles and planes.
fn directions(count: usize) -> Vec<Vec3> {
    let special = [-1.0, -1.0e-4, -1.0e-30, -0.0, 0.0, 1.0e-30, 1.0e-7, 1.0e-4, 0.5, 1.0];
    let triples = special.iter().flat_map(|&x| special.iter().flat_map(move |&y| special.map(|z| vec3(x, y, z))));
    let mut all: Vec<Vec3> = triples.filter(|v| v.length() > 1.0e-5).map(Vec3::normalize).collect();
    let mut numbers = Numbers::new(3);
    all.resize_with(count, || numbers.unit_vector().as_vec3());
    all
}

fn inputs(resolution: u32) -> Vec<MapInput> {
    let points = points();
    let directions = directions(points.len());
    let bins = (0..resolution * resolution).cycle();
    let all = points.iter().zip(directions).zip(bins);
    all.map(|((&p, w), bin)| MapInput { p: p.into(), w: w.into(), bin }).collect()
}

/// Distance in the square to the nearest border between bins.
fn from_border(p: DVec2, resolution: u32) -> f64 {
    let cells = (0.5 * p + 0.5) * f64::from(resolution);
    (cells - cells.round()).abs().min_element() * 2.0 / f64::from(resolution)
}

#[test]
fn the_map_is_its_twin_both_ways() {
    for map in MAPS {
        check_both_ways(map);
    }
}

fn check_both_ways(map: DirectionMap) {
    let device = Device::new();
    let inputs = inputs(16);
    let outputs: Vec<MapOutput> = device.map(&test::DIRECTION_MAP, &variant(map, 16), &inputs);
    let mut worst = [0.0_f64; 7];
    for (i, o) in inputs.iter().zip(&outputs) {
        let (p, w) = (d2(i.p), d3(i.w));
        let errors = [
            (d3(o.w_of_p) - map_to_sphere(map, p)).length(),
            (d3(o.w_of_p).length() - 1.0).abs(),
            (d3(o.w_of_antipode) + d3(o.w_of_p)).length(),
            // Several points on the square's border stand for one direction, so directions are compared.
            direction_error(map, d2(o.p_of_w), w.normalize()),
            (map_to_sphere(map, d2(o.p_of_w_of_p)) - map_to_sphere(map, p)).length(),
            (map_to_sphere(map, d2(o.antipode_of_p)) + map_to_sphere(map, p)).length(),
            (d3(o.center) - bin_center(map, i.bin, 16)).length(),
        ];
        assert!(d2(o.p_of_w).abs().max_element() <= 1.0 && d2(o.antipode_of_p).abs().max_element() <= 1.0, "{o:?}");
        worst = std::array::from_fn(|k| worst[k].max(errors[k]));
    }
    assert!(worst.iter().all(|&e| e < 1.0e-6), "errors {worst:?}");
}

/// Distance of a map point's direction from `w`. At the poles of the cylinder, the height in single precision
/// determines the distance from the pole badly. There, the height itself is compared, and the azimuth.
fn direction_error(map: DirectionMap, p: DVec2, w: DVec3) -> f64 {
    match map {
        DirectionMap::EqualArea => (map_to_sphere(map, p) - w).length(),
        DirectionMap::Cylindrical => {
            let azimuth = DVec2::from_angle(std::f64::consts::PI * p.x) * w.truncate().length();
            (azimuth - w.truncate()).length().max((p.y - w.z).abs())
        }
    }
}

#[test]
fn points_away_from_borders_are_unique() {
    for map in MAPS {
        check_uniqueness(map);
    }
}

/// Points off the square's border (its seam) come back as the same points, not only as the same directions.
fn check_uniqueness(map: DirectionMap) {
    let device = Device::new();
    let inputs = inputs(16);
    let outputs: Vec<MapOutput> = device.map(&test::DIRECTION_MAP, &variant(map, 16), &inputs);
    let mut compared = 0;
    for (i, o) in inputs.iter().zip(&outputs) {
        let (p, q) = (d2(i.p), twin::sphere_to_map(map, d3(i.w).normalize()));
        if p.abs().max_element() < 1.0 {
            assert!((d2(o.p_of_w_of_p) - p).length() < 2.0e-6, "{p} became {:?}", o.p_of_w_of_p);
            assert!((d2(o.antipode_of_p) - twin::map_antipode(map, p)).length() < 1.0e-6, "antipode of {p}");
        }
        if q.abs().max_element() < 0.999 && d3(i.w).abs().min_element() > 1.0e-6 {
            assert!((d2(o.p_of_w) - q).length() < 2.0e-6, "{:?} became {:?}, not {q}", i.w, o.p_of_w);
            compared += 1;
        }
    }
    assert!(compared > 60_000);
}

#[test]
fn bins_are_their_twins() {
    for (map, resolution) in MAPS.into_iter().flat_map(|map| [8, 16, 32].map(|resolution| (map, resolution))) {
        let device = Device::new();
        let inputs = inputs(resolution);
        let outputs: Vec<MapOutput> = device.map(&test::DIRECTION_MAP, &variant(map, resolution), &inputs);
        let mut near_borders = 0;
        for (i, o) in inputs.iter().zip(&outputs) {
            // These bins are exact, because the points and the borders of bins are exact.
            assert_eq!(o.bin_of_p, square_bin(d2(i.p), resolution), "{:?}", i.p);
            assert_eq!(o.bin_of_center, i.bin);
            let q = twin::sphere_to_map(map, d3(i.w).normalize());
            if from_border(q, resolution) < 2.0e-6 {
                near_borders += 1;
            } else {
                assert_eq!(o.bin_of_w, square_bin(q, resolution), "{:?}", i.w);
            }
            assert!(o.bin_of_w < resolution * resolution);
        }
        assert!(near_borders < 1000, "{near_borders}");
    }
}

#[test]
fn a_map_that_is_slightly_off_is_noticed() {
    // The twin must fail: an azimuth that is off by 2e-6 of a quadrant exceeds the tolerance.
    for map in MAPS {
        let p = dvec2(0.3, 0.4);
        let wrong = map_to_sphere(map, p + dvec2(-2.0e-6, 2.0e-6));
        assert!((wrong - map_to_sphere(map, p)).length() > 1.0e-6);
    }
}
