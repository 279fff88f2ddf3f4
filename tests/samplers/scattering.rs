//! Scattering functions of `glsl/include/bsdf/rough_diffuse.glsl`, `bsdf/principled.glsl`, `coating.glsl` and `sheen.glsl`:
//! samples of the device against the twins' densities, values against the twins', energy and reciprocity.

use std::f64::consts::{PI, TAU};

use bytemuck::{Pod, Zeroable};
use glam::{DQuat, DVec2, DVec3, Vec3, dvec2, dvec3};
use lodestar::generated::kernels::{Variant, test};
use lodestar::gpu::Kernel;
use rayon::prelude::*;
use support::device::{Device, GROUP};
use support::scattering_cases::{Base, DeviceBsdf, Surface, surfaces, variant};
use support::statistics::{Numbers, chi_square, mean_and_error, sidak};
use support::substances::{Substance, table_words};
use support::tier;
use support::twins::sheen::Sheen;

use crate::fixture::{Row, rows};

/// Probability that any correct sampler is rejected by chance.
const SIGNIFICANCE: f64 = 0.01;
const SAMPLES: usize = 1 << 17;
pub const LOBE_NONE: u32 = 0;
pub const LOBE_DELTA: u32 = 3;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct ScatteringInput {
    pub bsdf: DeviceBsdf,
    pub wo: [f32; 3],
    pub wi: [f32; 3],
    pub u: [f32; 3],
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct ScatteringOutput {
    pub wi: [f32; 3],
    pub lobe: u32,
    pub weight: [f32; 3],
    pub eta: f32,
    pub pdf: f32,
    pub value: [f32; 3],
}

pub fn d3(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

/// Directions from normal to grazing incidence. For surfaces that transmit light, some come from behind. The quick tier
/// has one direction on each side.
fn incidences(surface: &Surface) -> Vec<DVec3> {
    let at = |degrees: f64, side: f64| {
        let theta = degrees.to_radians();
        // The device gets the direction in single precision.
        dvec3(0.8 * theta.sin(), -0.6 * theta.sin(), side * theta.cos()).as_vec3().normalize().as_dvec3()
    };
    let mut all = tier::some_of(&[at(75.0, 1.0), at(40.0, 1.0), at(0.0, 1.0), at(88.0, 1.0)], 1).to_vec();
    if surface.transmits() {
        all.extend(tier::some_of(&[at(60.0, -1.0), at(20.0, -1.0)], 1));
    }
    all
}

/// Device with the pipeline of the kernel.
pub struct Bench {
    device: Device,
    kernel: Kernel,
}

impl Bench {
    pub fn new() -> Self {
        Self::with(&variant())
    }

    pub fn with(variant: &Variant) -> Self {
        let device = Device::new();
        let kernel = device.kernel(&test::SCATTERING, variant);
        Self { device, kernel }
    }

    pub fn map(&self, inputs: &[ScatteringInput]) -> Vec<ScatteringOutput> {
        let groups = inputs.len().div_ceil(GROUP as usize);
        let padded = groups * GROUP as usize;
        let input = self.device.storage("inputs", padded * size_of::<ScatteringInput>());
        input.upload(0, inputs).expect("uploaded");
        let output = self.device.storage("outputs", padded * size_of::<ScatteringOutput>());
        let tables = self.device.uploaded("tables", &table_words());
        // Parameters are given directly, so only tables are looked up.
        let unused = self.device.storage("unused", 256);
        let bindings = self.kernel.source().sets.iter().flat_map(|set| set.bindings);
        let buffers = bindings.map(|binding| match binding.name {
            "ScatteringInputs" => &input,
            "ScatteringOutputs" => &output,
            "TexelWords" | "texel_words" => &tables,
            _ => &unused,
        });
        self.device.dispatch(&self.kernel, &buffers.collect::<Vec<_>>(), &[], groups as u32);
        output.read(0, inputs.len()).expect("read")
    }
}

fn draw(bench: &Bench, surface: &Surface, wo: DVec3, seed: u32) -> Vec<ScatteringOutput> {
    let mut numbers = Numbers::new(seed);
    let input = |_| ScatteringInput {
        bsdf: surface.device(),
        wo: wo.as_vec3().into(),
        wi: [0.0, 0.0, 1.0],
        u: [(); 3].map(|()| numbers.unit() as f32),
    };
    let inputs: Vec<_> = (0..SAMPLES).map(input).collect();
    bench.map(&inputs)
}

/// Partition of the sphere into the two sides of the surface. Each side has polar coordinates about the direction in
/// which a smooth surface sends light. Angles grow geometrically, because lobes are narrow.
struct Bins {
    axes: [DQuat; 2],
    upper: bool,
}

const RINGS: usize = 14;
const SECTORS: usize = 12;
/// Number of points along each side over which a bin is integrated.
const POINTS: usize = 32;
/// Outer angle of the first ring.
const NARROWEST: f64 = 2.0e-3;

fn outer_angle(ring: f64) -> f64 {
    if ring < 1.0 { NARROWEST * ring } else { NARROWEST * (PI / NARROWEST).powf((ring - 1.0) / (RINGS - 1) as f64) }
}

impl Bins {
    const COUNT: usize = 2 * RINGS * SECTORS;

    fn new(wo: DVec3, eta: f64) -> Self {
        let relative = if wo.z > 0.0 { eta } else { 1.0 / eta };
        let across = -wo.truncate() / relative;
        let depth = (1.0 - across.length_squared()).max(0.0).sqrt().copysign(-wo.z);
        let through = across.extend(depth).normalize();
        let axes = [dvec3(-wo.x, -wo.y, wo.z), through].map(|axis| DQuat::from_rotation_arc(DVec3::Z, axis));
        Self { axes, upper: wo.z > 0.0 }
    }

    fn bin(&self, w: DVec3) -> usize {
        let side = usize::from((w.z > 0.0) != self.upper);
        let local = self.axes[side].inverse() * w;
        let angle = local.truncate().length().atan2(local.z);
        let ring = 1.0 + (angle / NARROWEST).ln() / (PI / NARROWEST).ln() * (RINGS - 1) as f64;
        let ring = (ring.max(0.0) as usize).min(RINGS - 1);
        let sector = (local.y.atan2(local.x) / TAU).rem_euclid(1.0) * SECTORS as f64;
        (side * RINGS + ring) * SECTORS + (sector as usize).min(SECTORS - 1)
    }

    /// Integrals of two densities over all bins.
    fn integrals(&self, pdf: impl Fn(DVec3) -> DVec2 + Sync) -> Vec<DVec2> {
        (0..Self::COUNT)
            .into_par_iter()
            .map(|bin| {
                let (side, ring, sector) = (bin / SECTORS / RINGS, bin / SECTORS % RINGS, bin % SECTORS);
                let step = 1.0 / POINTS as f64;
                let at = |i: usize, start: usize| start as f64 + (i as f64 + 0.5) * step;
                let ring_area = |i: usize| {
                    let edges = [i, i + 1].map(|i| outer_angle(ring as f64 + i as f64 * step).cos());
                    (edges[0] - edges[1]) * TAU / (SECTORS * POINTS) as f64
                };
                let mut sum = DVec2::ZERO;
                for i in 0..POINTS {
                    let (sine, cosine) = outer_angle(at(i, ring)).sin_cos();
                    let row: DVec2 = (0..POINTS)
                        .map(|j| {
                            let phi = TAU * at(j, sector) / SECTORS as f64;
                            let w = self.axes[side] * dvec3(sine * phi.cos(), sine * phi.sin(), cosine);
                            let inside = ((w.z > 0.0) == self.upper) == (side == 0);
                            if inside { pdf(w) } else { DVec2::ZERO }
                        })
                        .sum();
                    sum += row * ring_area(i);
                }
                sum
            })
            .collect()
    }
}

/// P-values of chi-square tests of samples against the twin's density and its probability of single directions. The
/// second p-value is that of a fault: a density 5 % higher in one half of all directions, and lower in the other.
fn fit(surface: &Surface, wo: DVec3, samples: &[ScatteringOutput]) -> [f64; 2] {
    let bins = Bins::new(wo, surface.eta());
    let mut observed = vec![0_u64; Bins::COUNT + 1];
    for s in samples.iter().filter(|s| s.lobe != LOBE_NONE) {
        observed[if s.lobe == LOBE_DELTA { Bins::COUNT } else { bins.bin(d3(s.wi)) }] += 1;
    }
    let tamper = |wi: DVec3| if wi.x > 0.3 * wi.y { 1.05 } else { 0.95 };
    let mut expected = bins.integrals(|wi| surface.pdf(wo, wi) * dvec2(1.0, tamper(wi)));
    expected.push(DVec2::splat(surface.delta(wo)));
    let expected_counts = |i: usize| expected.iter().map(|share| share[i] * samples.len() as f64).collect::<Vec<_>>();
    [0, 1].map(|i| chi_square(&observed, &expected_counts(i)))
}

/// Samples have the twin's density. The quick tier has every second case.
#[test]
fn samples_have_the_twins_density() {
    let bench = Bench::new();
    let cases: Vec<_> =
        surfaces().into_iter().flat_map(|s| incidences(&s).into_iter().map(move |wo| (s.clone(), wo))).collect();
    let level = sidak(SIGNIFICANCE, cases.len());
    let stride = if tier::is_full() { 1 } else { 2 };
    for (seed, (surface, wo)) in (100..).zip(&cases).step_by(stride) {
        let samples = draw(&bench, surface, *wo, seed);
        let [p, tampered] = fit(surface, *wo, &samples);
        println!("seed {seed}, wo {wo:.3}, {}: p = {p:.3}", surface.name);
        assert!(p > level, "p = {p}, wo {wo}, {}", surface.name);
        if surface.delta(*wo) < 0.3 {
            assert!(tampered < level, "the twin: p = {tampered}, wo {wo}, {}", surface.name);
        }
    }
}

/// Relative difference of two values. Light from `wi` may be a small fraction of the light that is reflected below, so
/// a floor is added.
pub fn relative(a: DVec3, b: DVec3) -> f64 {
    (a - b).length() / (b.length() + 1.0e-3)
}

/// Change of values and densities when the directions' last bits change. Half vectors of narrow lobes lose digits.
fn conditioning(surface: &Surface, wo: DVec3, wi: DVec3) -> f64 {
    let (value, pdf) = (surface.eval(wo, wi), DVec3::splat(surface.pdf(wo, wi)));
    let change = |off: DVec3| {
        let moved = [(wo, (wi + off).normalize()), ((wo + off).normalize(), wi)];
        let changes = moved.map(|(wo, wi)| {
            relative(surface.eval(wo, wi), value).max(relative(DVec3::splat(surface.pdf(wo, wi)), pdf))
        });
        changes[0].max(changes[1])
    };
    DVec3::AXES.into_iter().map(|axis| change(2.0e-7 * axis)).fold(0.0, |sum, change| sum + change)
}

/// Pairs of directions. Half of them are near the reflection or transmission of a smooth surface.
fn pairs(surface: &Surface, count: usize, seed: u32) -> Vec<[DVec3; 2]> {
    let mut numbers = Numbers::new(seed);
    let pair = |i: usize| {
        let mut wo = numbers.unit_vector();
        wo.z = wo.z.abs().max(0.02) * if surface.transmits() && i.is_multiple_of(3) { -1.0 } else { 1.0 };
        let wo = wo.normalize().as_vec3().as_dvec3();
        let side = usize::from(surface.transmits() && i.is_multiple_of(4));
        let smooth = Bins::new(wo, surface.eta()).axes[side] * DVec3::Z;
        let spread = if i.is_multiple_of(2) { 0.2 } else { 3.0 };
        let wi = (smooth + spread * numbers.unit() * numbers.unit_vector()).normalize();
        [wo, wi.as_vec3().as_dvec3()]
    };
    (0..count).map(pair).collect()
}

#[test]
fn values_and_densities_are_the_twins() {
    let bench = Bench::new();
    let mut tampered = 0;
    for (seed, surface) in (300..).zip(&surfaces()) {
        let pairs: Vec<_> = pairs(surface, 4096, seed).into_iter().filter(|[_, wi]| wi.z.abs() > 0.01).collect();
        let given = |[wo, wi]: &[DVec3; 2]| ScatteringInput {
            bsdf: surface.device(),
            wo: wo.as_vec3().into(),
            wi: wi.as_vec3().into(),
            u: [0.5; 3],
        };
        let outputs = bench.map(&pairs.iter().map(given).collect::<Vec<_>>());
        let mut worst = [0.0_f64; 2];
        for ([wo, wi], o) in pairs.iter().zip(&outputs) {
            let (value, pdf) = (surface.eval(*wo, *wi), surface.pdf(*wo, *wi));
            let off = [relative(d3(o.value), value), relative(DVec3::splat(o.pdf.into()), DVec3::splat(pdf))];
            let tolerance = surface.tolerance() + conditioning(surface, *wo, *wi);
            assert!(
                off[0].max(off[1]) < tolerance,
                "{off:?} for {wo} {wi}: {o:?}, not {value} {pdf}, {}",
                surface.name
            );
            worst = [worst[0].max(off[0]), worst[1].max(off[1])];
            tampered += usize::from(relative(d3(o.value), 1.01 * value) > tolerance);
        }
        println!("{}: largest relative deviations {worst:.1?}e-6", surface.name, worst = worst.map(|x| 1.0e6 * x));
    }
    assert!(tampered > 10_000, "the twin that is 1 % brighter differs in {tampered} places only");
}

/// Largest asymmetry of f for two directions on one side. `twist` adds a fault.
fn asymmetry(surface: &Surface, twist: f64) -> f64 {
    let pairs = pairs(surface, 4096, 77).into_iter().filter(|[wo, wi]| wo.z > 0.05 && wi.z > 0.05);
    // Facets treat a vector that is not quite a unit vector as another angle.
    let pairs = pairs.map(|pair| pair.map(DVec3::normalize));
    let deviation = |[wo, wi]: [DVec3; 2]| {
        let there = surface.eval(wo, wi) / wi.z * (1.0 + twist * (wo.x - wi.x));
        relative(there, surface.eval(wi, wo) / wo.z)
    };
    pairs.map(deviation).fold(0.0, f64::max)
}

/// Reflection is reciprocal for the twins, which agree with the device. Sheen, hair and the base of a plastic under a film, which follow the
/// viewer's direction alone, are not. Nor are interpolated tables.
#[test]
fn reflection_is_reciprocal() {
    let is_one_way = |s: &Surface| {
        let is_filmed_plastic =
            |b: &Substance| matches!(b, Substance::Plastic(_) | Substance::PolarizedPlastic(_)) && b.film().is_some();
        s.sheen.is_some()
            || matches!(&s.base, Base::Substance(Substance::Hair(_) | Substance::Measured(..)))
            || matches!(&s.base, Base::Substance(b) if is_filmed_plastic(b))
    };
    let (one_way, others): (Vec<_>, Vec<_>) = surfaces().into_iter().partition(is_one_way);
    assert!(one_way.iter().all(|s| asymmetry(s, 0.0) > 1.0e-2));
    for surface in others.iter().filter(|s| s.delta(DVec3::Z) < 0.9) {
        assert!(asymmetry(surface, 0.0) < 1.0e-5, "{}: {}", surface.name, asymmetry(surface, 0.0));
        assert!(asymmetry(surface, 0.05) > 1.0e-2, "the twin, {}", surface.name);
    }
}

/// Largest share of the light from one direction that leaves a white surface, and four standard errors of it.
fn most_reflected(bench: &Bench, surface: &Surface) -> (f64, f64) {
    let shares = incidences(surface).into_iter().zip(500..).map(|(wo, seed)| {
        let samples = draw(bench, surface, wo, seed);
        // Radiance that enters a denser medium grows. Its power does not.
        let power = |s: &ScatteringOutput| f64::from(s.weight[0]) * f64::from(s.eta).powi(2);
        let weights = samples.iter().filter(|s| s.lobe != LOBE_NONE).map(power);
        let invalid = samples.iter().filter(|s| s.lobe == LOBE_NONE).map(|_| 0.0);
        let (mean, error) = mean_and_error(weights.chain(invalid));
        (mean, 4.0 * error)
    });
    shares.fold((0.0, 0.0), |most, share| if share.0 > most.0 { share } else { most })
}

/// White surfaces of the energy-preserving model reflect all light, at every roughness. Its mean of what one reflection loses is a fit.
#[test]
fn energy_preserving_surfaces_lose_no_light() {
    let bench = Bench::new();
    let of_kind =
        |prefix: &str| surfaces().into_iter().filter(|surface| surface.name.starts_with(prefix)).collect::<Vec<_>>();
    let shares = |surface: &Surface| {
        let white = surface.white();
        let of_incidence = |(wo, seed)| {
            let samples = draw(&bench, &white, wo, seed);
            mean_and_error(samples.iter().map(|s| if s.lobe == LOBE_NONE { 0.0 } else { f64::from(s.weight[0]) }))
        };
        incidences(&white).into_iter().zip(700..).map(of_incidence).collect::<Vec<_>>()
    };
    let loses = |(mean, error): &(f64, f64)| (mean - 1.0).abs() > 2.0e-3 + 4.0 * error;
    let surfaces = of_kind("energy-preserving diffuse");
    assert_eq!(surfaces.len(), 3);
    for surface in &surfaces {
        let shares = shares(surface);
        println!("{}: {shares:?}", surface.name);
        assert!(!shares.iter().any(loses), "{}: {shares:?}", surface.name);
    }
    let twin = shares(&of_kind("rough diffuse 1 ")[0]);
    assert!(twin.iter().any(loses), "the twin, Oren and Nayar's model, loses light: {twin:?}");
}

/// Directions of light for which white sheens over white diffuse surfaces reflect more or less light than they get, where the device
/// is given a darker base.
fn sheens_that_lose(bench: &Bench, base: f64) -> usize {
    let is_diffuse = |s: &Surface| s.sheen.is_some() && matches!(s.base, Base::Diffuse(_));
    let lost = |surface: &Surface| {
        let white = Surface { base: Base::Diffuse(DVec3::splat(base)), ..surface.white() };
        let loses = |(wo, seed)| {
            let samples = draw(bench, &white, wo, seed);
            let weight = |s: &ScatteringOutput| if s.lobe == LOBE_NONE { 0.0 } else { f64::from(s.weight[0]) };
            let (mean, error) = mean_and_error(samples.iter().map(weight));
            println!("{}, {wo:.3}: {mean:.5} +- {error:.5}", white.name);
            (mean - 1.0).abs() > 1.0e-4 + 4.0 * error
        };
        incidences(&white).into_iter().zip(800..).filter(|&case| loses(case)).count()
    };
    let all: Vec<_> = surfaces().into_iter().filter(is_diffuse).collect();
    assert_eq!(all.len(), 4);
    all.iter().map(lost).sum()
}

/// A white sheen over a white diffuse surface reflects all light: the base has what the sheen leaves. A base that is 2 % darker is found.
#[test]
fn sheens_gain_and_lose_no_light() {
    let bench = Bench::new();
    assert_eq!(sheens_that_lose(&bench, 1.0), 0);
    assert!(sheens_that_lose(&bench, 0.98) > 0, "the twin: a darker base loses no light");
}

/// Rows in which the twin or the device differs from what a white sheen reflects in Cycles, times `tamper`.
fn sheens_unlike_cycles(tamper: f64) -> usize {
    let rows = rows("sheen/values.json");
    let surface = |row: &Row| {
        let sheen = Sheen { reflectance: DVec3::ONE, roughness: row.number("roughness") };
        Surface { sheen: Some(sheen), ..Surface::plain("sheen", Base::Diffuse(DVec3::ZERO)) }
    };
    let single = |v: DVec3| v.as_vec3().into();
    let input = |row: &Row| ScatteringInput {
        bsdf: surface(row).device(),
        wo: single(row.vector("wo")),
        wi: single(row.vector("wi")),
        u: [0.5; 3],
    };
    let outputs = Bench::new().map(&rows.iter().map(input).collect::<Vec<_>>());
    let differs = |(row, output): &(&Row, &ScatteringOutput)| {
        let theirs = tamper * row.number("value");
        let ours = [surface(row).eval(row.vector("wo"), row.vector("wi")).x, f64::from(output.value[0])];
        ours.iter().any(|value| (value - theirs).abs() > 2.0e-3 * theirs + 1.0e-5)
    };
    assert_eq!(rows.len(), 256);
    rows.iter().zip(&outputs).filter(differs).count()
}

/// Values of the lobe are Cycles', between the entries of the table, too.
#[test]
fn sheens_are_cycles() {
    assert_eq!(sheens_unlike_cycles(1.0), 0);
    assert!(sheens_unlike_cycles(1.005) > 150, "the twin, which is 0.5 % brighter");
}

/// White surfaces reflect at most the light that arrives. Sheen, clear coat and retro-reflection of the principled model are added without
/// regard for energy, so only metal and glass of the principled model are tested. Oren and Nayar's fit itself exceeds 1
/// by up to 4 % at grazing incidence. The original Ward model and Duer's are not bounded.
#[test]
fn white_surfaces_reflect_no_more_than_they_get() {
    let bench = Bench::new();
    let mut tampered = 0;
    let unbounded = ["ward Original", "ward Duer"];
    let is_bounded = |s: &&Surface| !s.name.ends_with("all") && unbounded.iter().all(|name| !s.name.starts_with(name));
    for surface in surfaces().iter().filter(is_bounded) {
        let limit = if surface.name.starts_with("rough diffuse") { 1.045 } else { 1.0 };
        let white = surface.white();
        let (most, error) = most_reflected(&bench, &white);
        println!("{}: {most:.4} +- {error:.4}", surface.name);
        assert!(most <= limit + error + 1.0e-4, "{most} +- {error}: {}", surface.name);
        tampered += usize::from(1.05 * most > limit + error);
    }
    assert!(tampered >= 6, "the twin: 5 % more is too much on {tampered} surfaces only");
}
