//! Directions of `glsl/include/math/direction.glsl` and reconstruction filters of `glsl/include/film/camera.glsl`.

use std::f64::consts::{FRAC_PI_4, TAU};

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec2, DVec3, Vec2, Vec3, dvec2, vec3};
use lodestar::generated::kernels::{FILTER_BOX, FILTER_GAUSSIAN, FILTER_TENT, Variant, test};
use support::device::Device;
use support::statistics::{Numbers, pair_uniformity};
use support::twins::{camera, direction};

const SIGNIFICANCE: f64 = 1.0e-3;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct DirectionInput {
    n: [f32; 3],
    u: [f32; 2],
    angle: f32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct DirectionOutput {
    basis: [f32; 9],
    cosine: [f32; 3],
    pdf: f32,
    disk: [f32; 2],
    sin_cos: [f32; 2],
    filtered: [f32; 2],
}

/// Largest number below one that a kernel draws.
const LAST: f32 = 1.0 - 1.0 / 16_777_216.0;

fn inputs() -> Vec<DirectionInput> {
    let mut numbers = Numbers::new(11);
    let mut normals = Vec::new();
    for z in [1.0_f32, -1.0, 0.0, -0.0, 1.0e-30, -1.0e-30, 1.0e-7, -1.0e-7] {
        let r = (1.0 - z * z).max(0.0).sqrt();
        normals.extend([vec3(r, 0.0, z), vec3(0.0, -r, z), vec3(-0.6 * r, 0.8 * r, z)]);
    }
    // Normals next to -z, where Frisvad's basis fails. The tested basis repairs it.
    normals.extend([1.0e-3, 1.0e-4, 3.0e-5].map(|x| vec3(x, -x, -1.0).normalize()));
    let corners = [0.0, 1.0 / 16_777_216.0, 0.25, 0.5, LAST].into_iter();
    let mut points: Vec<Vec2> = corners.clone().flat_map(|x| corners.clone().map(move |y| Vec2::new(x, y))).collect();
    let count = 1 << 16;
    normals.resize_with(count, || numbers.unit_vector().as_vec3());
    points.resize_with(count, || Vec2::new(numbers.unit() as f32, numbers.unit() as f32));
    let angle = |i: usize| (2.0 * i as f32 / (count - 1) as f32 - 1.0) * FRAC_PI_4 as f32;
    let all = normals.iter().zip(points).enumerate();
    all.map(|(i, (n, u))| DirectionInput { n: (*n).into(), u: u.into(), angle: angle(i) }).collect()
}

fn run(filter: u32) -> Vec<(DirectionInput, DirectionOutput)> {
    let inputs = inputs();
    let variant = Variant { filter, filter_width: 1.5, ..Variant::default() };
    let outputs = Device::new().map(&test::DIRECTION, &variant, &inputs);
    inputs.into_iter().zip(outputs).collect()
}

fn d3(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

fn d2(v: [f32; 2]) -> DVec2 {
    Vec2::from(v).as_dvec2()
}

#[test]
fn bases_are_orthonormal_and_right_handed() {
    for (i, o) in run(FILTER_BOX) {
        let basis = DMat3::from_cols_array(&o.basis.map(f64::from));
        assert_eq!(basis.z_axis, d3(i.n));
        let product = basis.transpose() * basis - DMat3::IDENTITY;
        let worst = product.to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(worst < 2.0e-6, "{i:?}: {basis}");
        assert!((basis.determinant() - 1.0).abs() < 2.0e-6, "{i:?}: {basis}");
        let twin = direction::basis_from_normal(d3(i.n));
        // Next to -z the basis turns fast with the normal, so there it must only be a basis.
        let near_pole = i.n[2] < -0.999;
        assert!(near_pole || (basis.x_axis - twin.x_axis).length() < 1.0e-5, "{i:?}: {basis}");
    }
}

#[test]
fn sines_and_cosines_are_exact_to_rounding() {
    let error = |scale: f64| {
        let errors = run(FILTER_BOX).into_iter().map(move |(i, o)| {
            (d2(o.sin_cos) - direction::sin_cos_quarter(f64::from(i.angle) * scale)).abs().max_element()
        });
        errors.fold(0.0, f64::max)
    };
    assert!(error(1.0) < 2.0e-7, "{}", error(1.0));
    assert!(error(1.0 + 1.0e-6) > 2.0e-7, "the twin");
}

#[test]
fn cosine_hemisphere_is_its_twin_and_has_its_density() {
    let results = run(FILTER_BOX);
    for (i, o) in &results {
        let w = d3(o.cosine);
        let twin = direction::sample_cosine_hemisphere(d2(i.u));
        assert!((d2(o.disk) - direction::concentric_disk(d2(i.u))).length() < 1.0e-6, "{i:?} {o:?}");
        // Next to the horizon, the height is the root of a difference, so its square is compared.
        assert!((w - twin).truncate().length() < 1.0e-6 && (w.z * w.z - twin.z * twin.z).abs() < 1.0e-6, "{i:?} {o:?}");
        assert!((w.length() - 1.0).abs() < 1.0e-6 && w.z >= 0.0, "{i:?} {o:?}");
        assert!((f64::from(o.pdf) - direction::pdf_cosine_hemisphere(w.z)).abs() < 1.0e-6);
    }
    // The density cos / pi is uniform in cos^2 and azimuth.
    let fit = |power: f64| {
        pair_uniformity(
            results
                .iter()
                .map(|(_, o)| (1.0 - f64::from(o.cosine[2]).powf(power), turn(d2([o.cosine[0], o.cosine[1]])))),
            16,
        )
    };
    assert!(fit(2.0) > SIGNIFICANCE, "{}", fit(2.0));
    assert!(fit(2.1) < SIGNIFICANCE, "the twin: {}", fit(2.1));
}

/// Azimuth as a fraction of a turn.
fn turn(d: DVec2) -> f64 {
    (d.y.atan2(d.x) / TAU).rem_euclid(1.0)
}

#[test]
fn the_box_filter_is_a_pixel() {
    assert!(run(FILTER_BOX).iter().all(|(i, o)| i.u == o.filtered));
}

#[test]
fn the_tent_is_its_twin_and_has_its_density() {
    let results = run(FILTER_TENT);
    for (i, o) in &results {
        let twin = 0.5 + 1.5 * dvec2(camera::sample_tent(f64::from(i.u[0])), camera::sample_tent(f64::from(i.u[1])));
        assert!((d2(o.filtered) - twin).length() < 2.0e-6, "{i:?}: {o:?}");
    }
    // The cumulative tent of the given radius makes the numbers uniform.
    let cumulative =
        |x: f64| if x < 0.0 { (1.0 + x).max(0.0).powi(2) / 2.0 } else { 1.0 - (1.0 - x).max(0.0).powi(2) / 2.0 };
    let fit = |radius: f64| {
        let unit = results.iter().map(move |(_, o)| (d2(o.filtered) - 0.5) / radius);
        pair_uniformity(unit.map(|d| (cumulative(d.x), cumulative(d.y))), 16)
    };
    assert!(fit(1.5) > SIGNIFICANCE, "{}", fit(1.5));
    assert!(fit(1.5 * 1.05) < SIGNIFICANCE, "the twin: {}", fit(1.5 * 1.05));
}

#[test]
fn the_gaussian_is_its_twin_and_has_its_density() {
    let results = run(FILTER_GAUSSIAN);
    for (i, o) in &results {
        let twin = 0.5 + 1.5 * camera::sample_gaussian(d2(i.u));
        // The logarithm loses digits next to the center and at the rim.
        let tolerance = if (1.0e-3..0.999).contains(&i.u[0]) { 1.0e-4 } else { 2.0e-3 };
        assert!((d2(o.filtered) - twin).length() < tolerance, "{i:?}: {o:?}, not {twin}");
        assert!((d2(o.filtered) - 0.5).length() < 1.5 * 4.001, "{i:?}: {o:?}");
    }
    let fit = |deviation: f64| {
        let unit = results.iter().map(move |(_, o)| (d2(o.filtered) - 0.5) / deviation);
        pair_uniformity(unit.map(|d| ((-0.5 * d.length_squared()).exp(), turn(d))), 16)
    };
    assert!(fit(1.5) > SIGNIFICANCE, "{}", fit(1.5));
    assert!(fit(1.5 * 1.05) < SIGNIFICANCE, "the twin: {}", fit(1.5 * 1.05));
}
