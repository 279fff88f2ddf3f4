//! Area lights of `glsl/include/light/light.glsl` and `light_shape.glsl`: samples against the density of the twin.

use std::f64::consts::PI;

use glam::{DVec3, Vec3, dvec3, vec3};
use lodestar::scene::{Cone, Primitive, PrimitiveShape};
use lodestar::settings::DirectionMap;
use support::primitives::primitive;
use support::statistics::{chi_square, sidak, sphere};
use support::twins::direction_map::direction_bin;
use support::twins::intersect::turned;
use support::twins::light::{area, pdf_primitive};

use crate::lights::{LightOutput, d3, draw_from, emitting};

const SIGNIFICANCE: f64 = 0.01;
const SAMPLES: usize = 1 << 18;
/// Bins of the histogram along each side of the equal-area square.
const HISTOGRAM: u32 = 32;

fn ball(center: Vec3, radius: f32) -> Primitive {
    primitive(PrimitiveShape::Sphere, center, Vec3::X * radius, Vec3::Z * radius)
}

fn facing(center: Vec3, radius: f32) -> Primitive {
    Primitive { shape: PrimitiveShape::FacingDisk, ..ball(center, radius) }
}

/// Lights, and the point that sees them.
struct Case {
    name: &'static str,
    lights: Vec<(Primitive, f32)>,
    from: DVec3,
}

fn cases() -> Vec<Case> {
    let case = |name, primitive, from| Case { name, lights: vec![(primitive, 3.0)], from };
    let triangle = primitive(PrimitiveShape::Triangle, vec3(-1.0, 0.5, 0.2), vec3(2.0, 0.3, 0.1), vec3(0.2, 0.4, 1.5));
    let parallelogram =
        primitive(PrimitiveShape::Parallelogram, vec3(0.0, 1.0, 0.0), vec3(0.3, 0.1, 1.0), vec3(0.8, 0.2, 0.1));
    let disk = primitive(PrimitiveShape::Disk, vec3(0.0, 0.0, 1.0), vec3(0.9, 0.0, 0.2), vec3(0.0, 0.7, 0.0));
    let sphere = ball(vec3(0.2, 0.1, -0.3), 1.0);
    let mixed = vec![
        (triangle, 1.0),
        (Primitive { origin: vec3(0.0, -1.0, 0.0), ..parallelogram }, 2.0),
        (Primitive { flip_normal: true, ..disk }, 0.5),
        (ball(vec3(2.0, 0.0, -1.0), 0.8), 0.7),
        (ball(vec3(-2.0, 0.0, 0.0), 0.5), 0.0),
        (facing(vec3(-1.0, 2.0, -1.0), 0.6), 0.9),
    ];
    vec![
        case("triangle", triangle, dvec3(0.0, 0.0, 0.0)),
        case("parallelogram", parallelogram, dvec3(0.1, 0.0, 0.1)),
        case("disk", disk, dvec3(0.1, -0.1, 0.2)),
        case("disk at a grazing angle", disk, dvec3(1.6, 0.1, 1.0)),
        case("sphere from outside", sphere, dvec3(1.2, 0.9, 0.6)),
        case("sphere from its rim", sphere, sphere.origin.as_dvec3() + 1.0006 * dvec3(0.48, 0.64, 0.6)),
        case("sphere from its surface", sphere, sphere.origin.as_dvec3() + 1.0002 * dvec3(0.48, 0.64, 0.6)),
        case("sphere from within", sphere, dvec3(0.5, 0.4, 0.0)),
        case("facing disk", facing(sphere.origin, 1.0), dvec3(1.2, 0.9, 0.6)),
        case("facing disk within its radius", facing(sphere.origin, 1.0), dvec3(0.5, 0.4, 0.0)),
        Case { name: "several", lights: mixed, from: dvec3(0.0, 0.0, 0.0) },
    ]
}

impl Case {
    /// Density of a direction seen from `from`, with lights chosen by power.
    fn pdf(&self, from: DVec3, direction: DVec3) -> f64 {
        let power = |(p, radiance): &(Primitive, f32)| area(p) * PI * f64::from(*radiance);
        let sum: f64 = self.lights.iter().map(power).sum();
        self.lights.iter().map(|light| power(light) / sum * pdf_primitive(&light.0, from, direction)).sum()
    }

    /// P-value of a chi-square test of the samples against the density seen from `from`.
    fn fit(&self, drawn: &[LightOutput], from: DVec3, factor: f64) -> f64 {
        let mut counts = vec![0; (HISTOGRAM * HISTOGRAM) as usize];
        drawn.iter().for_each(|s| counts[direction_bin(DirectionMap::EqualArea, s.wi(), HISTOGRAM) as usize] += 1);
        let masses = sphere(DirectionMap::EqualArea).integrals(HISTOGRAM, |w| self.pdf(from, w));
        let expected: Vec<f64> = masses.iter().map(|mass| mass * factor * drawn.len() as f64).collect();
        chi_square(&counts, &expected)
    }
}

#[test]
fn directions_to_area_lights_follow_their_density() {
    let cases = cases();
    let level = sidak(SIGNIFICANCE, cases.len());
    for (case, seed) in cases.iter().zip(1..) {
        let drawn = draw_from(&case.lights_scene(), case.from, SAMPLES, seed);
        let p = case.fit(&drawn, case.from, 1.0);
        assert!(p > level, "{}: chi-square {p}", case.name);
        let denser = case.fit(&drawn, case.from, 1.05);
        let elsewhere = case.fit(&drawn, case.from + dvec3(0.02, -0.03, 0.02), 1.0);
        assert!(denser < level && elsewhere < level, "{}: the twins {denser}, {elsewhere}", case.name);
    }
}

impl Case {
    fn lights_scene(&self) -> lodestar::scene::Scene {
        emitting(&self.lights)
    }
}

/// Samples and hits have equal density and radiance. Only single lights are tested, because a ray hits the nearest of
/// several lights.
#[test]
fn a_sample_and_a_hit_have_the_same_density_and_radiance() {
    for (case, seed) in cases().iter().filter(|case| case.lights.len() == 1).zip(21..) {
        let drawn = draw_from(&case.lights_scene(), case.from, SAMPLES, seed);
        let (light, radiance) = case.lights[0];
        let mut differing = 0;
        for s in &drawn {
            let twin = case.pdf(case.from, s.wi());
            let grazing =
                (d3(s.target) - case.from).normalize().dot(normal(&turned(&light, case.from), d3(s.target))).abs()
                    < 0.02;
            let agrees = |pdf: f32, tolerance: f64| (f64::from(pdf) / twin - 1.0).abs() < tolerance;
            // Near the outline, rounding decides whether a ray hits the light.
            let far_hit = light.shape == PrimitiveShape::Sphere && case.name.contains("surface");
            let same = agrees(s.pdf, 1.0e-3) && agrees(s.along_wi.pdf, 1.0e-3) && s.radiance == s.along_wi.radiance;
            differing += usize::from(!same && !grazing && !far_hit);
            assert!(s.delta == 0 && s.infinite == 0 && s.pdf > 0.0);
            assert!(s.radiance == [radiance; 3] || s.radiance == [0.0; 3], "{}: {s:?}", case.name);
            assert_eq!(s.radiance != [0.0; 3], faces(&turned(&light, case.from), s), "{}: {s:?}", case.name);
        }
        println!("{}: {differing} of {} differ", case.name, drawn.len());
        assert!(differing <= drawn.len() / 500, "{}: {differing} of {} differ", case.name, drawn.len());
    }
}

fn normal(p: &Primitive, at: DVec3) -> DVec3 {
    match p.shape {
        PrimitiveShape::Sphere => (at - p.origin.as_dvec3()).normalize(),
        _ => p.edge_u.as_dvec3().cross(p.edge_v.as_dvec3()).normalize(),
    }
}

/// Whether the light's front faces the sampled direction.
fn faces(p: &Primitive, s: &LightOutput) -> bool {
    normal(p, d3(s.target)).dot(s.wi()) < 0.0
}

#[test]
fn lights_without_weight_or_radiance_are_never_drawn() {
    let triangle = primitive(PrimitiveShape::Triangle, vec3(-1.0, 0.5, 0.2), vec3(2.0, 0.3, 0.1), vec3(0.2, 0.4, 1.5));
    let disk = primitive(PrimitiveShape::Disk, vec3(0.0, 0.0, 1.0), vec3(0.9, 0.0, 0.2), vec3(0.0, 0.7, 0.0));
    let mut scene = emitting(&[(triangle, 1.0), (disk, 5.0)]);
    scene.emitters[1].sampling_weight = 0.0;
    let drawn = draw_from(&scene, DVec3::ZERO, 4096, 5);
    assert!(drawn.iter().all(|s| s.radiance != [5.0; 3] && pdf_primitive(&triangle, DVec3::ZERO, s.wi()) > 0.0));
}

/// Where an emitter has a cone, the radiance of a sample and of a hit falls as Blender's spots do.
#[test]
fn a_cone_dims_what_leaves_beside_its_axis() {
    let axis = vec3(0.48, -0.64, 0.6);
    let center = vec3(0.2, 0.1, -0.3);
    let cone = Cone { axis, cos_cutoff: 0.6, cos_beam: 0.8 };
    for light in [facing(center, 0.7), ball(center, 0.7)] {
        let mut scene = emitting(&[(light, 3.0)]);
        scene.emitters[0].cone = Some(cone);
        let from = center.as_dvec3() + 1.5 * axis.as_dvec3() + dvec3(0.9, 0.3, -0.5);
        let drawn = draw_from(&scene, from, 4096, 31);
        let share = |s: &LightOutput, cone: &Cone| {
            let [low, high] = [cone.cos_cutoff, cone.cos_beam];
            let x = ((-s.wi().dot(cone.axis.as_dvec3()) - low) / (high - low)).clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        };
        let agree = |cone: &Cone| {
            let is_right = |s: &&LightOutput| (f64::from(s.radiance[0]) - 3.0 * share(s, cone)).abs() < 1.0e-4;
            drawn.iter().filter(is_right).count()
        };
        let met = drawn.iter().filter(|s| s.radiance == s.along_wi.radiance).count();
        let dimmed = drawn.iter().filter(|s| (0.01..2.99).contains(&s.radiance[0])).count();
        println!("{:?}: {met} are met, {dimmed} are dimmed", light.shape);
        assert!(agree(&cone) == drawn.len() && met > 4000 && dimmed > 1000, "{:?}: {}", light.shape, agree(&cone));
        assert!(agree(&Cone { cos_beam: 0.85, ..cone }) < 3000, "{:?}: the twin", light.shape);
    }
}
