//! Learned shares of `glsl/include/guide/learners/share_learning.glsl`: updates from a step's evidence, and directions
//! drawn by shares.

use std::f64::consts::PI;
use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use lodestar::generated::kernels::{BSDF_DIFFUSE, BSDF_ROUGH_CONDUCTOR, GUIDE_SET_ALL, STORAGE_BUFFERS, Variant, test};
use lodestar::generated::layout::{LearnedRadiance, RadianceSum, SceneConstants, UpdatePush};
use lodestar::gpu::{Buffer, BufferKind};
use lodestar::math::direction_map::bin_center;
use lodestar::math::microfacet::Microfacets;
use lodestar::settings::{DirectionMap, Mix, Sampler};
use support::device::{Cell, Device, GROUP};
use support::guide_cases::{NORMALS, variant};
use support::sampled_directions::{DirectionOutput, SeenSurface, draw};
use support::scattering_cases::{Base, DeviceBsdf, Surface};
use support::statistics::{Numbers, mean_and_error, within_four_sigma};
use support::substances::Substance;
use support::twins::conductor::Conductor;
use support::twins::direction::basis_from_normal;
use support::twins::normalization_entry::Rules;
use support::twins::radiance_grid::FIXED_POINT_UNITS;

const LIMIT: f32 = 32.0;
const CELLS: u32 = 3;
const DIRECTIONS: u32 = 16;
const BINS: u32 = DIRECTIONS * DIRECTIONS;
/// Constants of `share_learning.glsl`.
const FIRST_SHARE: f64 = 0.5;
const FIRST_SAMPLES: f64 = 64.0;
const LEAST_SHARE: f64 = 0.1;
const SHARE_DECAY: f64 = 0.5;

/// Evidence of one step about a share.
#[derive(Clone, Copy)]
struct Evidence {
    scattered: f64,
    of_guide: f64,
    samples: u32,
}

/// Share after these steps, the last one last: twin of `learn_share`.
fn learned_share(steps: &[Evidence], decay: f64) -> f64 {
    let faded = |value: fn(&Evidence) -> f64| -> f64 {
        steps.iter().rev().zip(0..).map(|(step, age)| value(step) * decay.powi(age)).sum()
    };
    let (scattered, of_guide) = (faded(|e| e.scattered), faded(|e| e.of_guide));
    let samples = faded(|e| f64::from(e.samples));
    let learned = if scattered > 0.0 { 1.0 - of_guide / scattered } else { FIRST_SHARE };
    let share = FIRST_SHARE + (learned - FIRST_SHARE) * samples / (samples + FIRST_SAMPLES);
    share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
}

/// Tables of a few cells, and the kernel that ends a step.
struct Grid {
    device: Device,
    scene: Arc<Buffer>,
    radiance: Arc<Buffer>,
    learned: Arc<Buffer>,
    sums: Arc<Buffer>,
}

const SHARES: usize = 2 * CELLS as usize;

impl Grid {
    fn new() -> Self {
        let device = Device::new();
        let (bins, shares) = ((CELLS * BINS) as usize, SHARES);
        let scene = device.buffer("scene", size_of::<SceneConstants>(), BufferKind::Uniform);
        scene
            .upload(0, &[SceneConstants { target_limit: LIMIT, cell_count: CELLS, ..SceneConstants::zeroed() }])
            .expect("uploaded");
        Self {
            radiance: device.storage("radiance", (bins + 4 * shares) * size_of::<f32>()),
            learned: device.storage("learned", bins * size_of::<LearnedRadiance>()),
            sums: device.storage("sums", (bins + 2 * shares) * size_of::<RadianceSum>()),
            scene,
            device,
        }
    }

    /// Shares after a step.
    fn update(&self, step: &[Evidence]) -> Vec<f32> {
        let units = |value: f64| (value / f64::from(LIMIT) * FIXED_POINT_UNITS) as u64;
        let sum = |value: f64, target_count| {
            let units = units(value);
            RadianceSum { low: units as u32, high: (units >> 32) as u32, target_count, flux: 0.0 }
        };
        let sums: Vec<_> =
            step.iter().flat_map(|e| [sum(e.scattered, e.samples), sum(e.of_guide, e.samples)]).collect();
        self.sums.upload(u64::from(CELLS * BINS) * size_of::<RadianceSum>() as u64, &sums).expect("uploaded");
        let named = [
            ("Scene", &self.scene),
            ("RadianceTable", &self.radiance),
            ("LearnedTable", &self.learned),
            ("RadianceSums", &self.sums),
        ];
        let variant = Variant { learns_share: true, direction_resolution: DIRECTIONS, ..Variant::default() };
        let push = UpdatePush { first_cell: 0, ends_step: 1 };
        let kernel = &STORAGE_BUFFERS.update_radiance;
        self.device.dispatch_renderers(kernel, &variant, &named, bytemuck::bytes_of(&push), CELLS);
        let offset = u64::from(CELLS * BINS) * size_of::<f32>() as u64;
        let words: Vec<[f32; 4]> = self.radiance.read(offset, SHARES).expect("read");
        words.into_iter().map(|share| share[0]).collect()
    }
}

#[test]
fn shares_are_what_the_evidence_says() {
    let grid = Grid::new();
    let none = Evidence { scattered: 0.0, of_guide: 0.0, samples: 0 };
    assert_eq!(grid.update(&[none; SHARES]), [FIRST_SHARE as f32; SHARES], "without evidence");
    let mut numbers = Numbers::new(3);
    let mut steps = Vec::new();
    let mut differ = 0;
    for _ in 0..6 {
        // The last share has no evidence. The first has none of its own side.
        let step: Vec<_> = (0..SHARES)
            .map(|share| {
                let samples = if share + 1 == SHARES { 0 } else { numbers.between(1.0, 3000.0) as u32 };
                let scattered = f64::from(samples) * numbers.between(0.01, 2.0);
                let part = if share == 0 { 1.0 } else { numbers.unit() };
                Evidence { scattered, of_guide: part * scattered, samples }
            })
            .collect();
        steps.push(step);
        let shares = grid.update(&steps[steps.len() - 1]);
        for (share, value) in shares.iter().enumerate() {
            let of_share: Vec<_> = steps.iter().map(|step| step[share]).collect();
            let twin = learned_share(&of_share, SHARE_DECAY);
            assert!((f64::from(*value) - twin).abs() < 1.0e-4, "share {share}: {value}, not {twin}");
            differ += usize::from((f64::from(*value) - learned_share(&of_share, 0.6)).abs() > 1.0e-3);
        }
    }
    assert!(differ > SHARES, "hardly a share depends on the decay: {differ}");
}

const SAMPLES: usize = 1 << 19;
const RULES: Rules =
    Rules { sampler: Sampler::Product, mix: Mix::Density, epsilon: None, max_tries: 1, min_uniform_share: 0.0625 };

/// Diffuse surface and surface of rough metal, over a noisy table.
struct Surfaces {
    device: Device,
    cell: Cell,
}

const NORMAL: DVec3 = DVec3::new(0.3, -0.2, 0.9);
const WO: DVec3 = DVec3::new(0.6, 0.0, 0.8);

/// Roughness of the metal, and the part of its samples that the guide has its share of: `guided_part` in GLSL.
const ALPHA: f64 = 0.3;
const PART: f64 = ALPHA / 0.4;

fn metal() -> Surface {
    let metal =
        Conductor { specular_reflectance: DVec3::splat(0.9), eta: DVec3::splat(0.9), k: DVec3::splat(2.5), film: None };
    let facets = Microfacets::new([ALPHA; 2], true);
    Surface::plain("metal", Base::Substance(Substance::RoughConductor(metal, facets)))
}

impl Surfaces {
    fn new() -> Self {
        let device = Device::new();
        let cell = Cell::new(&device, &Self::variant());
        let mut numbers = Numbers::new(9);
        let table: Vec<f32> = (0..BINS).map(|_| 10_f64.powf(numbers.between(-1.0, 1.0)) as f32).collect();
        cell.fill(&device, &table);
        Self { device, cell }
    }

    fn variant() -> Variant {
        Variant {
            learns_share: true,
            normal_resolution: NORMALS,
            guide_set: GUIDE_SET_ALL,
            material_kinds: 1 << BSDF_ROUGH_CONDUCTOR | 1 << BSDF_DIFFUSE,
            ..variant(&RULES, DirectionMap::EqualArea)
        }
    }

    fn draw(&self, bsdf: DeviceBsdf, seed: u32) -> Vec<DirectionOutput> {
        let kernel = self.device.kernel(&test::SAMPLE_DIRECTION, &Self::variant());
        let surface = SeenSurface { bsdf, wo: WO, normal: NORMAL.normalize() };
        draw(&self.device, &self.cell, (&kernel, GROUP), surface, (seed, SAMPLES))
    }
}

/// Whether a direction lies in a certain part of the sphere.
fn is_inside(w: DVec3) -> bool {
    w.dot(DVec3::new(0.9, 0.3, 0.2)) > 0.4
}

/// Surface, and its scattering function in local directions.
struct Case {
    name: &'static str,
    bsdf: DeviceBsdf,
    eval: Box<dyn Fn(DVec3) -> f64>,
}

fn cases() -> [Case; 2] {
    let diffuse = DeviceBsdf::new(BSDF_DIFFUSE, [DVec3::splat(0.7), DVec3::ZERO, DVec3::ZERO]);
    let metal = metal();
    [
        Case { name: "diffuse", bsdf: diffuse, eval: Box::new(|wi| 0.7 * wi.z.max(0.0) / PI) },
        Case { name: "metal", bsdf: metal.device(), eval: Box::new(move |wi| metal.eval(WO, wi).element_sum() / 3.0) },
    ]
}

impl Case {
    fn value(&self, w: DVec3) -> f64 {
        (self.eval)(basis_from_normal(NORMAL.normalize()).transpose() * w)
    }

    /// Light that the surface scatters to the part of the sphere, by points.
    fn light(&self) -> f64 {
        let side = 1024;
        let points = (0..side * side).map(|point| bin_center(DirectionMap::EqualArea, point, side));
        let sum: f64 = points.filter(|&w| is_inside(w)).map(|w| self.value(w)).sum();
        sum * 4.0 * PI / f64::from(side * side)
    }

    /// Light that the surface scatters to the part of the sphere, by samples. `weight` gives the contribution of a
    /// sample. Returns the mean and its standard error.
    fn estimate(&self, drawn: &[DirectionOutput], weight: impl Fn(&DirectionOutput, DVec3) -> f64) -> (f64, f64) {
        mean_and_error(drawn.iter().map(|d| {
            let w = Vec3::from(d.wi).as_dvec3().normalize();
            if d.pdf > 0.0 && is_inside(w) { weight(d, w) } else { 0.0 }
        }))
    }
}

#[test]
fn weights_make_up_the_light_whatever_shares_are() {
    let surfaces = Surfaces::new();
    for (seed, shares) in (1..).zip([[0.1, 0.9], [0.6, 0.2]]) {
        surfaces.cell.set_shares(shares);
        for case in cases() {
            let title = format!("{}, shares {shares:?}", case.name);
            let (drawn, light) = (surfaces.draw(case.bsdf, seed), case.light());
            let is_apart = |d: &&DirectionOutput| {
                let is_reached = case.value(Vec3::from(d.wi).as_dvec3()) > 0.0;
                is_reached && (d.pdf - d.pdf_of_wi).abs() > 2.0e-3 * d.pdf
            };
            let apart = drawn.iter().filter(is_apart).count();
            assert!(apart <= SAMPLES / 2000, "{title}: {apart} densities are not their direction's");
            let mean = |d: &DirectionOutput, _| d.weight.iter().map(|&weight| f64::from(weight)).sum::<f64>() / 3.0;
            let estimate = case.estimate(&drawn, mean);
            assert!(within_four_sigma(estimate, light), "{title}: {estimate:?}, not {light}");
            let by_density = case.estimate(&drawn, |d, w| case.value(w) / f64::from(d.pdf));
            assert!(within_four_sigma(by_density, light), "{title}: {by_density:?} by density, {light}");
            // The twin must fail: a density 5 % off.
            let twin = case.estimate(&drawn, |d, w| case.value(w) / f64::from(1.05 * d.pdf));
            assert!(!within_four_sigma(twin, light), "{title}: {twin:?} by a density 5 % off, {light}");
        }
    }
}

#[test]
fn each_kind_of_surface_has_its_own_share() {
    let surfaces = Surfaces::new();
    for (own, case) in cases().iter().enumerate() {
        let densities = |shares| {
            surfaces.cell.set_shares(shares);
            let drawn = surfaces.draw(case.bsdf, 7);
            drawn.iter().map(|d| f64::from(d.pdf_of_given)).collect::<Vec<_>>()
        };
        let shares = |own_share, other| if own == 0 { [own_share, other] } else { [other, own_share] };
        let [few, more, most] = [0.2, 0.5, 0.8].map(|share| densities(shares(share, 0.4)));
        assert!(few == densities(shares(0.2, 0.9)), "{}: the other share has a part in it", case.name);
        // A share halfway between two others has a density halfway between theirs.
        let is_between = |i: usize| (2.0 * more[i] - few[i] - most[i]).abs() <= 1.0e-4 * more[i];
        assert!((0..few.len()).all(is_between), "{}", case.name);
        let changed = few.iter().zip(&most).filter(|(few, most)| few != most).count();
        assert!(changed > few.len() / 4, "{}: {changed} densities depend on the share", case.name);
    }
}

/// Samples report the evidence for their share: the probability that they came from the guide. It follows from the
/// density of the surface's own sampler, over the part of the samples that the share is about.
#[test]
fn samples_tell_who_has_drawn_them() {
    let surfaces = Surfaces::new();
    let shares = [0.3_f32, 0.6];
    surfaces.cell.set_shares(shares);
    let metal = metal();
    for (own, case) in cases().iter().enumerate() {
        let part = [1.0, PART][own];
        let frame = basis_from_normal(NORMAL.normalize());
        let own_density = |w: DVec3| match own {
            0 => (frame.transpose() * w).z.max(0.0) / PI,
            _ => metal.pdf(WO, frame.transpose() * w),
        };
        let drawn = surfaces.draw(case.bsdf, 11);
        let scattered: Vec<_> = drawn.iter().filter(|d| d.weight[0] > 0.0).collect();
        assert!(scattered.len() > SAMPLES / 2);
        let differences = |kept: f64, factor: f64| {
            let is_off = |d: &&&DirectionOutput| {
                let of_own = kept * own_density(Vec3::from(d.wi).as_dvec3().normalize()) / f64::from(d.pdf);
                let mean = d.weight.iter().map(|&weight| f64::from(weight)).sum::<f64>() / 3.0;
                let is_known = (1.0 - factor * f64::from(d.of_guide) - of_own).abs() < 5.0e-3;
                !is_known || (f64::from(d.scattered) - factor * mean).abs() > 1.0e-4 * mean
            };
            scattered.iter().filter(is_off).count()
        };
        let kept = 1.0 - part * (1.0 - f64::from(shares[own]));
        let (wrong, few) = (differences(kept, part), SAMPLES / 2000);
        assert!(wrong <= few, "{}: {wrong} of {} differ", case.name, scattered.len());
        assert!(differences(1.1 * kept, part) > SAMPLES / 4, "{}: no share is told", case.name);
    }
}
