//! Relief of `glsl/include/geometry/relief.glsl`.

use std::f64::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3, Vec3};
use lodestar::generated::kernels::{Variant, test};
use support::device::Device;
use support::twins::relief::{
    bump_normal, mapped_normal, mirrored_height, raised_normal, relief_frame, relief_shadowing,
};

use crate::fixture::{Row, rows};

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct ReliefInput {
    dp_du: [f32; 3],
    dp_dv: [f32; 3],
    geometric_normal: [f32; 3],
    gradient: [f32; 2],
    color: [f32; 3],
    is_bump: u32,
    wo: [f32; 3],
    wi: [f32; 3],
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct ReliefOutput {
    frame: [f32; 9],
    wo: [f32; 3],
    wi: [f32; 3],
    shadowing: f32,
    raised: [f32; 3],
}

fn input(row: &Row) -> ReliefInput {
    let vector = |name| row.vector(name).as_vec3().into();
    ReliefInput {
        dp_du: vector("dp_du"),
        dp_dv: vector("dp_dv"),
        geometric_normal: vector("geometric"),
        gradient: row.numbers("gradient").map(|x| x as f32),
        color: vector("color"),
        is_bump: u32::from(row.is("bump")),
        wo: vector("wo"),
        wi: vector("wi"),
    }
}

fn twins_frame(row: &Row) -> DMat3 {
    let n = if row.is("bump") {
        let gradient = row.numbers("gradient").into();
        bump_normal(row.vector("dp_du"), row.vector("dp_dv"), gradient, row.vector("geometric"))
    } else {
        mapped_normal(row.vector("color"))
    };
    relief_frame(n, row.vector("wo"))
}

/// Value f cos of a tilted white diffuse surface.
fn diffuse(wo: DVec3, wi: DVec3, shadowing: f64) -> f64 {
    if wo.z > 0.0 { wi.z.max(0.0) * shadowing / PI } else { 0.0 }
}

/// Largest deviation of the twin's values from Mitsuba's. `shadowing` replaces the factor of shadowing.
fn twins_deviation(shadowing: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let deviation = |row: &Row| {
        let (frame, wi) = (twins_frame(row), row.vector("wi"));
        let [wo, tilted] = [row.vector("wo"), wi].map(|w| frame.transpose() * w);
        (diffuse(wo, tilted, shadowing(frame.z_axis, wi)) - row.number("eval")).abs()
    };
    rows("relief/values.json").iter().map(deviation).fold(0.0, f64::max)
}

#[test]
fn the_twin_has_mitsubas_values() {
    assert!(twins_deviation(relief_shadowing) < 2.0e-6, "{}", twins_deviation(relief_shadowing));
    let unshadowed = |n: DVec3, wi: DVec3| if n.dot(wi) * wi.z > 0.0 { 1.0 } else { 0.0 };
    assert!(twins_deviation(unshadowed) > 1.0e-2, "the twin without shadowing: {}", twins_deviation(unshadowed));
    let through = |n: DVec3, wi: DVec3| relief_shadowing(n, if n.dot(wi) * wi.z > 0.0 { wi } else { DVec3::Z });
    assert!(twins_deviation(through) > 1.0e-2, "the twin that lights from below: {}", twins_deviation(through));
}

#[test]
fn the_device_is_its_twin() {
    let rows = rows("relief/values.json");
    let inputs: Vec<_> = rows.iter().map(input).collect();
    let outputs: Vec<ReliefOutput> = Device::new().map(&test::RELIEF, &Variant::default(), &inputs);
    let d3 = |v: [f32; 3]| Vec3::from(v).as_dvec3();
    for (row, o) in rows.iter().zip(&outputs) {
        let (frame, twin) = (DMat3::from_cols_array(&o.frame.map(f64::from)), twins_frame(row));
        let worst = (frame - twin).to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(worst < 3.0e-6, "{frame}, not {twin}: {row:?}");
        let value = diffuse(d3(o.wo), d3(o.wi), f64::from(o.shadowing));
        assert!((value - row.number("eval")).abs() < 3.0e-6, "{value}: {o:?} {row:?}");
    }
}

/// Normals are raised as by bisection, and never farther than their mirror directions need.
#[test]
fn normals_are_raised_until_their_mirror_directions_leave_the_surface() {
    let mut inputs = Vec::new();
    for at in 0..1000 {
        let [tilt, azimuth, rise] = [0.618_034, 0.754_878, 0.819_173].map(|step| (step * f64::from(at)).fract());
        let (tilt, azimuth, rise) = (1.4 * tilt, 2.0 * PI * azimuth, 0.001 + 0.999 * rise);
        let n = DVec3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
        let wo = DVec3::new(-(1.0 - rise * rise).sqrt(), 0.0, rise);
        let color = (0.5 * (n + 1.0)).as_vec3().into();
        inputs.push(ReliefInput { color, wo: wo.as_vec3().into(), ..ReliefInput::zeroed() });
    }
    let outputs: Vec<ReliefOutput> = Device::new().map(&test::RELIEF, &Variant::default(), &inputs);
    let mut raised = 0;
    for (input, output) in inputs.iter().zip(&outputs) {
        let n = mapped_normal(Vec3::from(input.color).as_dvec3()).normalize();
        let (wo, found) = (Vec3::from(input.wo).as_dvec3(), Vec3::from(output.raised).as_dvec3());
        let twin = raised_normal(n, wo);
        raised += u32::from(twin != n);
        // Vulkan allows arc functions an error of 4096 units in the last place.
        assert!((found - twin).length() < 2.0e-4, "{found}, not {twin}: {n}, {wo}");
        assert!(mirrored_height(found, wo) > 0.0, "{found}: {n}, {wo}");
    }
    assert!(raised > 100 && raised < 900, "{raised} of 1000");
}
