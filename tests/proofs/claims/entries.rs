//! Claim: after a step, every marked entry of the normalization grid equals the brute-force result for the radiance
//! table. No other entry is filled.

use std::f64::consts::TAU;

use lodestar::encode::cosine_integrals::cosine_integrals;
use lodestar::generated::layout;
use lodestar::math::direction_map::representative_normal;
use lodestar::renderer::RenderState;
use lodestar::settings::{DirectionMap, SamplePattern, Sampler, Settings};
use support::scenes::ours;
use support::statistics::sphere;
use support::twins::normalization_entry::{
    NormalizationEntry, Rules, inversion_factors, normalizer_and_bound, rejection_factors,
};
use support::twins::product::Product;

use crate::evidence::Evidence;
use crate::renders::Studio;
use crate::rows::{Scope, kind_of};
use crate::subject::Subject;

const SIDE: u32 = 32;
const STEPS: u32 = 3;
const SEED: u32 = 400;
/// Allowed relative error of a factor, which is a sum of hundreds of numbers in single precision.
const TOLERANCE: f64 = 3.0e-5;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    let studio = Studio::new();
    let scene = ours("cornell-box/scene.xml", &[]);
    // Inversion over the sphere has one entry per cell, whose factors are the same for every table.
    for row in scope.guided().iter().filter(|row| kind_of(row).rules.sampler != Sampler::SphereInversion) {
        let mut settings = Settings {
            width: SIDE,
            height: SIDE,
            seed: SEED,
            grid: Some(4),
            normals: 8,
            nee: false,
            pattern: SamplePattern::Independent,
            ..Settings::for_scene(&scene)
        };
        row.set(&mut settings);
        let settings = subject.settings(settings);
        let cosines: Vec<_> =
            (0..settings.normals.pow(2) as usize).map(|normal| Cosines::new(&settings, normal)).collect();
        let mut renderer = studio.renderer(subject, &scene, settings.clone());
        for step in 1..=STEPS {
            renderer.step(settings.spp_per_step, &|| false).expect("a step");
            let case = format!("{}, step {step}, seed {SEED}", row.name);
            check(&renderer.state().expect("a state"), &settings, &cosines, &kind_of(row).rules, &case, evidence);
        }
    }
}

fn part<T: bytemuck::Pod>(state: &RenderState, name: &str) -> Vec<T> {
    let part = state.parts.iter().find(|part| part.name == name).unwrap_or_else(|| panic!("no part {name}"));
    bytemuck::pod_collect_to_vec(&part.bytes)
}

fn check(
    state: &RenderState,
    settings: &Settings,
    cosines: &[Cosines],
    rules: &Rules,
    case: &str,
    evidence: &mut Evidence,
) {
    let table: Vec<f32> = part(state, "radiance");
    let entries: Vec<layout::NormalizationEntry> = part(state, "normalizers");
    let marks: Vec<u32> = part(state, "marked normalizers");
    let words: &[[u32; 4]] = bytemuck::cast_slice(&entries);
    let (bins, normals) = (settings.directions.pow(2) as usize, cosines.len());
    let (mut marked, mut wrong, mut unasked) = (0, None, 0);
    for (normal, cosines) in cosines.iter().enumerate() {
        for cell in 0..entries.len() / normals {
            let index = cell * normals + normal;
            let entry = &entries[index];
            if marks[index / 32] >> (index % 32) & 1 == 0 {
                unasked += usize::from(words[index] != [0; 4]);
                continue;
            }
            marked += 1;
            let radiance = &table[cell * bins..(cell + 1) * bins];
            let off = match rules.sampler {
                Sampler::Product => block_difference(&words[index], radiance, cosines),
                _ => difference(entry, radiance, cosines, rules),
            };
            if off.is_nan() || off >= TOLERANCE {
                wrong = Some((cell, normal, off));
            }
        }
    }
    evidence.hold(format!("marks, {case}"), marked > 100, || format!("only {marked} entries are marked"));
    evidence.hold(format!("unmarked entries, {case}"), unasked == 0, || format!("{unasked} of them are filled"));
    evidence
        .hold(format!("marked entries, {case}"), wrong.is_none(), || format!("(cell, normal, deviation): {wrong:?}"));
}

/// Clamped cosines over all direction bins, for one normal bin.
struct Cosines {
    /// Error of an integral, sr: see the tests of the normalizers.
    error: f64,
    integrals: Vec<f64>,
    /// The renderer's integrals. Their last digits decide how a sum is rounded to few bits.
    stored: Vec<f64>,
    maxima: Vec<f64>,
}

impl Cosines {
    fn new(settings: &Settings, normal: usize) -> Self {
        let &Settings { map, directions, normals, .. } = settings;
        let nb = representative_normal(normal as u32, normals);
        let bounds = cosine_integrals(map, directions, normals);
        let of_normal = || bounds.iter().skip(normal).step_by(normals.pow(2) as usize);
        let maxima = of_normal().map(|cosine| f64::from(cosine.maximum)).collect();
        let stored = of_normal().map(|cosine| f64::from(cosine.integral)).collect();
        let error = match map {
            DirectionMap::EqualArea => 4.0e-7,
            DirectionMap::Cylindrical => 3.0e-6,
        } * 16.0
            / f64::from(directions);
        Self { error, integrals: sphere(map).cosine_integrals(directions, nb), stored, maxima }
    }
}

/// Largest relative difference between the block weights that the product sampler stores and the twin's. The difference
/// is 0 for equal weights, and for neighbors where rounding may have decided.
fn block_difference(words: &[u32; 4], radiance: &[f32], cosines: &Cosines) -> f64 {
    let twin = Product { radiance, integrals: &cosines.stored }.block_weights();
    let code = |i: usize| words[i / 4] >> (7 * (i % 4)) & 127;
    let found = |i: usize| f64::from(f32::from_bits((code(i) << 20) + (112 << 23)));
    let off = |i: usize| (found(i) / twin[i] - 1.0).abs();
    let worst = (0..16).map(off).fold(0.0, f64::max);
    let inexact = (0..16).filter(|&i| off(i) > 1.0e-6).count();
    if worst < 0.126 && inexact <= 1 { 0.0 } else { worst }
}

/// Largest relative difference between any of the factors and the brute-force result.
fn difference(ours: &layout::NormalizationEntry, radiance: &[f32], cosines: &Cosines, rules: &Rules) -> f64 {
    let (normalizer, bound) = normalizer_and_bound(radiance, &cosines.integrals, &cosines.maxima);
    let twin: NormalizationEntry = match rules.sampler {
        Sampler::HemisphereInversion => inversion_factors(normalizer, radiance.len(), rules),
        _ => rejection_factors(normalizer, bound, rules),
    };
    // 1 - (1 - c)^K cancels where c is small, and c itself is rounded next to 1.
    let cancelled = match rules.sampler {
        Sampler::HemisphereInversion => 0.0,
        _ => 6.0e-8 / rules.accepted(normalizer / (TAU * bound), twin.uniform_share),
    };
    let pairs = [
        (ours.guide_scale, twin.guide_scale),
        (ours.uniform_density, twin.uniform_density),
        (ours.acceptance_scale, twin.acceptance_scale),
    ];
    let relative = pairs.map(|(a, b)| (f64::from(a) / b - 1.0).abs()).into_iter().fold(0.0, f64::max);
    // Next to the horizon, the brightest bin's contribution is mostly the error of its integral.
    let brightest = radiance.iter().copied().fold(0.0, f32::max);
    let approximate = cosines.error * f64::from(brightest) / normalizer;
    // Eq. 8 gives shares next to 0 with the rounding error of numbers next to 1.
    let share = (f64::from(ours.uniform_share) - twin.uniform_share).abs() / twin.uniform_share.max(0.0625);
    relative.max(share) - cancelled - approximate
}
