//! Dielectrics, conductors and plastics of `glsl/include/bsdf/*.glsl`: Mitsuba's values, single directions, reciprocity
//! between media, and extreme inputs. `scattering.rs` tests their samples together with those of all other kinds.

use glam::{DVec3, dvec3};
use lodestar::generated::kernels::{
    BSDF_MEASURED, BSDF_WARD, FEATURE_BECKMANN, FEATURE_ENERGY_PRESERVING, FEATURE_FILM, FEATURE_SMOOTH_BASE,
    FEATURE_WEIGHTED_BASE, MATERIAL_ENERGY_PRESERVING, MATERIAL_WEIGHTED_BASE, Variant, WARD_BALANCED,
};
use lodestar::math::microfacet::Microfacets;
use support::statistics::Numbers;
use support::substances::{Substance, plastic, substances};
use support::twins::conductor::Conductor;
use support::twins::delta::DeltaLobe;
use support::twins::dielectric::Dielectric;
use support::twins::hair::Hair;
use support::twins::polarized_plastic::PolarizedPlastic;

use crate::fixture::{Row, rows};
use crate::scattering::{Bench, LOBE_DELTA, LOBE_NONE, ScatteringInput, ScatteringOutput, d3, relative};

/// Largest number below one that a kernel draws.
const LAST: f32 = 1.0 - 1.0 / 16_777_216.0;

fn conductor(row: &Row) -> Conductor {
    let [specular_reflectance, eta, k] = ["specular_reflectance", "eta", "k"].map(|name| row.vector(name));
    Conductor { specular_reflectance, eta, k, film: None }
}

fn dielectric(row: &Row) -> Dielectric {
    let [specular_reflectance, specular_transmittance] =
        ["specular_reflectance", "specular_transmittance"].map(|name| row.vector(name));
    Dielectric { eta: row.number("eta"), specular_reflectance, specular_transmittance, film: None }
}

fn facets(row: &Row) -> Microfacets {
    Microfacets::new(["alpha_u", "alpha_v"].map(|name| row.number(name)), row.is("ggx"))
}

fn substance(row: &Row) -> Substance {
    let plastic_of = |facets| {
        let [diffuse, specular] = ["diffuse_reflectance", "specular_reflectance"].map(|name| row.vector(name));
        plastic(row.number("eta"), diffuse, specular, row.is("nonlinear"), facets)
    };
    match row.text("kind") {
        "conductor" => Substance::Conductor(conductor(row)),
        "roughconductor" => Substance::RoughConductor(conductor(row), facets(row)),
        "dielectric" => Substance::Dielectric(dielectric(row)),
        "thindielectric" => Substance::ThinDielectric(dielectric(row)),
        "roughdielectric" => Substance::RoughDielectric(dielectric(row), facets(row)),
        "plastic" => plastic_of(None),
        "roughplastic" => plastic_of(Some(Microfacets::new([row.number("alpha"); 2], row.is("ggx")))),
        "pplastic" => {
            let [diffuse_reflectance, specular_reflectance] =
                ["diffuse_reflectance", "specular_reflectance"].map(|name| row.vector(name));
            let (eta, facets) = (row.number("eta"), facets(row));
            let base_weight = None;
            Substance::PolarizedPlastic(PolarizedPlastic {
                eta,
                diffuse_reflectance,
                specular_reflectance,
                facets,
                base_weight,
                base_roughness: 0.0,
                film: None,
            })
        }
        "hair" => Substance::Hair(Hair {
            sigma_a: row.vector("sigma_a"),
            longitudinal_roughness: row.number("longitudinal_roughness"),
            azimuthal_roughness: row.number("azimuthal_roughness"),
            eta: row.number("eta"),
            tilt: row.number("scale_tilt").to_radians(),
        }),
        kind => panic!("no plugin {kind}"),
    }
}

fn input(substance: &Substance, wo: DVec3, wi: DVec3, u: [f32; 3]) -> ScatteringInput {
    ScatteringInput { bsdf: substance.device(), wo: wo.as_vec3().into(), wi: wi.as_vec3().into(), u }
}

/// Cases in which the twin or the device differs from Mitsuba's values and densities, multiplied by `tamper`.
fn differing(tamper: f64) -> Vec<String> {
    let rows = rows("bsdfs/values.json");
    let substances: Vec<_> = rows.iter().map(substance).collect();
    let inputs: Vec<_> = rows
        .iter()
        .zip(&substances)
        .map(|(row, substance)| input(substance, row.vector("wo"), row.vector("wi"), [0.5; 3]))
        .collect();
    let outputs = Bench::new().map(&inputs);
    let cases = rows.iter().zip(&substances).zip(&outputs);
    cases
        .flat_map(|((row, substance), output)| {
            let (wo, wi) = (row.vector("wo"), row.vector("wi"));
            let (value, pdf) = (tamper * row.vector("eval"), DVec3::splat(tamper * row.number("pdf")));
            let pdf_tolerance = pdf_tolerance(substance);
            let deviations = [
                ("twin's value", relative(substance.eval(wo, wi), value), value_tolerance(substance)),
                ("device's value", relative(d3(output.value), value), value_tolerance(substance)),
                ("twin's density", relative(DVec3::splat(substance.pdf(wo, wi)), pdf), pdf_tolerance),
                ("device's density", relative(DVec3::splat(output.pdf.into()), pdf), pdf_tolerance),
            ];
            // A `pplastic` chooses its lobes with other probabilities than Mitsuba's, and so does hair that is not gray.
            let compared = match substance {
                Substance::PolarizedPlastic(_) => 2,
                Substance::Hair(b) if b.sigma_a != DVec3::splat(b.sigma_a.x) => 2,
                _ => 4,
            };
            let differing =
                deviations.into_iter().take(compared).filter(|(_, deviation, tolerance)| deviation > tolerance);
            differing.map(move |(what, deviation, _)| format!("{what}: {deviation} {row:?}")).collect::<Vec<_>>()
        })
        .collect()
}

/// Allowed relative error of a value. Mitsuba's Bessel function of hair errs by up to 0.6 %; ours does not.
fn value_tolerance(substance: &Substance) -> f64 {
    if matches!(substance, Substance::Hair(_)) { 6.0e-3 } else { 1.0e-3 }
}

/// Allowed relative error of a density. Mitsuba approximates densities of Beckmann's visible facets with an error of up
/// to 0.4 %; ours are exact. Its quadrature for a layer of GGX has an error of 2e-4, which is up to 0.3 % of the
/// specular lobe's probability.
fn pdf_tolerance(substance: &Substance) -> f64 {
    match substance {
        Substance::RoughPlastic(..) => 5.0e-3,
        Substance::Hair(_) => value_tolerance(substance),
        _ if substance.facets().is_some_and(|facets| !facets.is_ggx) => 5.0e-3,
        _ => 1.0e-3,
    }
}

#[test]
fn values_are_mitsubas() {
    let differing_now = differing(1.0);
    assert!(differing_now.is_empty(), "{} differ:\n{}", differing_now.len(), differing_now.join("\n"));
    let tampered = differing(1.01);
    assert!(tampered.len() > 1000, "1 % more differs in {} places only", tampered.len());
}

/// Samples of the device in every single direction, for the smallest and for the largest number.
fn sampled_lobes(bench: &Bench, substance: &Substance, wo: DVec3) -> [ScatteringOutput; 2] {
    let samples = bench.map(&[0.0, LAST].map(|u| input(substance, wo, DVec3::Z, [0.5, 0.5, u])));
    [samples[0], samples[1]]
}

/// Rounding error of a cosine in single precision. It is the square root of a difference of numbers of size 1, so a
/// small cosine loses digits.
fn cosine_rounding(cosine: f64) -> f64 {
    f64::from(f32::EPSILON) / cosine.abs().max(1.0e-6)
}

fn is_lobe(sample: &ScatteringOutput, lobe: &DeltaLobe) -> bool {
    sample.lobe == LOBE_DELTA
        && (d3(sample.wi) - lobe.wi).length() < 2.0e-6 + cosine_rounding(lobe.wi.z)
        && relative(d3(sample.weight), lobe.value / lobe.probability) < 1.0e-4
        && (f64::from(sample.eta) - lobe.eta).abs() < 1.0e-6
}

#[test]
fn single_directions_are_mitsubas() {
    let bench = Bench::new();
    let mut tampered = 0;
    let rows = rows("bsdfs/single.json");
    for row in &rows {
        let (substance, wo) = (substance(row), row.vector("wo"));
        let (wi, weight, eta) = (row.vector("wi"), row.vector("weight"), row.number("bent"));
        let has = |weight: DVec3| {
            substance.lobes(wo).iter().any(|lobe| {
                (lobe.wi - wi).length() < 1.0e-5
                    && relative(lobe.value / lobe.probability, weight) < 1.0e-4
                    && (lobe.probability - row.number("probability")).abs() < 1.0e-5
                    && (lobe.eta - eta).abs() < 1.0e-5
            })
        };
        assert!(has(weight), "{row:?}: {:?}", substance.lobes(wo));
        tampered += usize::from(!has(1.001 * weight));
        let samples = sampled_lobes(&bench, &substance, wo);
        let lobe = DeltaLobe { wi, probability: 1.0, value: weight, eta };
        assert!(samples.iter().any(|sample| is_lobe(sample, &lobe)), "{row:?}: {samples:?}");
    }
    assert_eq!(tampered, rows.len(), "the twin: 0.1 % more");
}

/// Single directions have the probabilities of the twin. Just below and just above each number at which a lobe ends,
/// the device takes the twin's direction.
#[test]
fn single_directions_have_their_probabilities() {
    let bench = Bench::new();
    let mut numbers = Numbers::new(61);
    for (name, substance) in substances().iter().filter(|(_, substance)| !substance.lobes(DVec3::Z).is_empty()) {
        for i in 0..200 {
            let mut wo = numbers.unit_vector();
            wo.z = if substance.transmits() && i % 2 == 0 { -wo.z.abs() } else { wo.z.abs() };
            let wo = wo.as_vec3().as_dvec3();
            let lobes = substance.lobes(wo);
            let end = lobes[0].probability;
            // By Fresnel's equations, a probability changes by a few times as much as a cosine.
            let margin = 1.0e-5 + lobes.iter().map(|lobe| 8.0 * cosine_rounding(lobe.wi.z)).fold(0.0, f64::max);
            let ends_at = |end: f64| {
                let around = bench.map(&[-margin, margin].map(|off| {
                    let u = (end + off).clamp(0.0, LAST.into()) as f32;
                    input(substance, wo, DVec3::Z, [0.3, 0.6, u])
                }));
                let before_end = end < margin || is_lobe(&around[0], &lobes[0]);
                let after_end = match lobes.get(1) {
                    Some(lobe) => is_lobe(&around[1], lobe),
                    None => around[1].lobe != LOBE_DELTA,
                };
                before_end && (after_end || end > 1.0 - 2.0 * margin)
            };
            assert!(ends_at(end), "{name}, {wo}: not {lobes:?}, {:?}", sampled_lobes(&bench, substance, wo));
            if margin < 1.0e-4 && end < 0.99 {
                assert!(!ends_at(end + 2.0e-3), "the twin: a lobe that ends later; {name}, {wo}");
            }
        }
    }
}

/// Transmission is reciprocal: radiance over the squared index of refraction is symmetric in both directions, also
/// across a surface.
#[test]
fn transmission_is_reciprocal() {
    let asymmetry = |power: i32| {
        let mut numbers = Numbers::new(62);
        let mut worst = 0.0_f64;
        for (name, substance) in substances().iter().filter(|(_, substance)| substance.transmits()) {
            let Some(facets) = substance.facets() else { continue };
            let eta = substance.bending();
            for _ in 0..2000 {
                // The light direction is one that a facet near the mean normal transmits to.
                let wo = dvec3(numbers.between(-0.6, 0.6), numbers.between(-0.6, 0.6), 1.0).normalize();
                let slopes = DVec3::from([facets.alpha[0], facets.alpha[1], 0.0]) * numbers.unit_vector();
                let m = dvec3(slopes.x, slopes.y, 1.0).normalize();
                let cosine = wo.dot(m);
                let cos_t2 = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
                let wi = m * (cosine / eta - cos_t2.max(0.0).sqrt()) - wo / eta;
                if cos_t2 < 0.01 || wi.z > -0.05 {
                    continue;
                }
                let there = substance.eval(wo, wi) / wi.z.abs() * eta.powi(power);
                let back = substance.eval(wi, wo) / wo.z.abs();
                assert!(back.max_element() > 0.0, "{name}: nothing passes from {wi} to {wo}");
                worst = worst.max((there - back).length() / back.length());
            }
        }
        worst
    };
    assert!(asymmetry(2) < 1.0e-9, "{}", asymmetry(2));
    assert!(asymmetry(0) > 0.1 && asymmetry(-2) > 0.1, "the twins: no scaling, and that of the other side");
}

/// Substances with minimum roughness, and with indices of refraction of one and next to one.
fn extremes() -> Vec<Substance> {
    let facets = [[0.0, 0.0], [1.0e-4, 1.0], [5.0, 1.0e-3]]
        .into_iter()
        .flat_map(|alpha| [false, true].map(|is_ggx| Microfacets::new(alpha, is_ggx)));
    let metals = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.01, 20.0), (5.0, 0.0)].map(|(eta, k)| Conductor {
        specular_reflectance: DVec3::ONE,
        eta: DVec3::splat(eta),
        k: DVec3::splat(k),
        film: None,
    });
    let glasses = [1.0, 1.0001, 0.3, 4.0].map(|eta| Dielectric {
        eta,
        specular_reflectance: DVec3::ONE,
        specular_transmittance: DVec3::ONE,
        film: None,
    });
    let mut all: Vec<_> = metals.map(Substance::Conductor).into();
    all.extend(glasses.map(Substance::Dielectric));
    all.extend(glasses.map(Substance::ThinDielectric));
    for eta in [1.0, 0.8, 2.5] {
        all.push(plastic(eta, DVec3::ONE, DVec3::ONE, true, None));
        all.push(plastic(eta, DVec3::ONE, DVec3::ONE, false, Some(Microfacets::new([1.0e-4; 2], true))));
    }
    for (along, around, eta, tilt) in
        [(0.0, 0.0, 1.55, 0.035), (1.0, 1.0, 0.5, 0.0), (0.0, 1.0, 4.0, -0.7), (1.0, 0.0, 1.001, 1.5)]
    {
        let sigma_a = DVec3::ZERO;
        all.push(Substance::Hair(Hair {
            sigma_a,
            longitudinal_roughness: along,
            azimuthal_roughness: around,
            eta,
            tilt,
        }));
    }
    for facets in facets {
        all.extend(metals.map(|b| Substance::RoughConductor(b, facets)));
        all.extend(glasses.map(|b| Substance::RoughDielectric(b, facets)));
    }
    all.extend(substances().into_iter().map(|(_, substance)| substance.white()));
    all
}

/// Directions that are grazing, along an axis, or opposite to each other, and random ones.
fn extreme_directions() -> Vec<DVec3> {
    let mut numbers = Numbers::new(63);
    let grazing = [0.0, -0.0, 1.0e-30, -1.0e-30, 1.0e-7, 1.0e-4, -1.0e-4, 0.01].map(|z| dvec3(0.6, -0.8, z));
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    grazing.into_iter().chain(axes).chain((0..8).map(|_| numbers.unit_vector())).collect()
}

fn is_sound(i: &ScatteringInput, o: &ScatteringOutput) -> bool {
    let all = [&o.wi[..], &o.weight, &o.value, &[o.eta, o.pdf]].concat();
    let finite = all.iter().all(|x| x.is_finite());
    let positive = o.weight.iter().chain(&o.value).chain([&o.pdf]).all(|&x| x >= 0.0);
    let unit = o.lobe == LOBE_NONE || (d3(o.wi).length() - 1.0).abs() < 1.0e-3;
    // A plastic may sample one of its two lobes less often than its brightness asks for. For other kinds, a weight
    // above 1 is rounding of narrow lobes. Ward's unbalanced models have no bound at grazing incidence. A rough base that keeps its
    // energy reflects at most 1.4 + 1 / cos of what a diffuse one does, where cos is that of the direction farther from the horizon.
    let is_plastic = i.bsdf.scalars[5] > 0.0;
    let is_unbounded = i.bsdf.kind_and_flags == BSDF_WARD && i.bsdf.scalars[4] != WARD_BALANCED;
    let is_rough_base = i.bsdf.kind_and_flags & MATERIAL_ENERGY_PRESERVING != 0;
    let rough = if is_rough_base { 1.4 + 1.0 / i.wo[2].abs().max(o.wi[2].abs()) } else { 1.0 };
    // Between the directions of a measured material, and between its points, tables that were interpolated differ.
    let is_table = i.bsdf.kind_and_flags == BSDF_MEASURED;
    // Lobes are chosen by the mean of what a film reflects, of which waves that meet in phase reflect up to twice as much.
    let is_filmed = i.bsdf.film[0] > 0.0;
    let weight = o.weight[0] * o.eta * o.eta;
    let energy = o.lobe == LOBE_NONE
        || is_unbounded
        || weight < rough * if is_plastic || is_table || is_filmed { 2.0 } else { 1.2 };
    finite && positive && unit && energy
}

#[test]
fn extreme_inputs_give_sound_outputs() {
    let bench = Bench::new();
    let directions = extreme_directions();
    let corners = [0.0, 1.0e-7, 0.25, 0.5, LAST];
    for substance in extremes() {
        let inputs: Vec<_> = directions
            .iter()
            .enumerate()
            .flat_map(|(i, &wo)| {
                let numbers = corners.iter().flat_map(|&x| corners.iter().map(move |&y| (x, y)));
                let others = directions.iter().cycle().skip(i);
                numbers.zip(others).flat_map(move |((x, y), &wi)| corners.map(|z| (wo, wi, [x, y, z])))
            })
            .map(|(wo, wi, u)| input(&substance, wo, wi, u))
            .collect();
        for (i, o) in inputs.iter().zip(bench.map(&inputs)) {
            assert!(is_sound(i, &o), "{substance:?}:\n{i:?}\n{o:?}");
        }
    }
}

/// Rounding error that the tests grant to a number of an input, relative to it: eight roundings of 2^-24 each.
const ROUNDING: f32 = 8.0 / 16_777_216.0;

/// How far apart two results of one input may lie, because rounding of the input would move them as far.
#[derive(Clone, Copy, Default)]
struct Tolerance {
    lobe: bool,
    wi: f64,
    pdf: f32,
    value: f32,
    weight: f32,
}

impl Tolerance {
    /// The larger of this tolerance and the differences of two results.
    fn including(self, a: &ScatteringOutput, b: &ScatteringOutput) -> Self {
        Self {
            lobe: self.lobe || a.lobe != b.lobe,
            wi: self.wi.max((d3(a.wi) - d3(b.wi)).length()),
            pdf: self.pdf.max((a.pdf - b.pdf).abs()),
            value: self.value.max((a.value[0] - b.value[0]).abs()),
            weight: self.weight.max((a.weight[0] - b.weight[0]).abs()),
        }
    }
}

/// The tolerance of each input: the largest change of its result where one number of the input changes by [`ROUNDING`]. It is
/// large where a result depends much on the last digits, such as at the rim of a narrow lobe.
fn tolerances(bench: &Bench, inputs: &[ScatteringInput]) -> Vec<Tolerance> {
    let exact = bench.map(inputs);
    let mut all = vec![Tolerance::default(); inputs.len()];
    for number in 0..9 {
        for factor in [1.0 - ROUNDING, 1.0 + ROUNDING] {
            let rounded: Vec<_> = inputs
                .iter()
                .map(|&input| {
                    let mut input = input;
                    let ScatteringInput { wo, wi, u, .. } = &mut input;
                    let x = &mut [wo, wi, u][number / 3][number % 3];
                    *x = if number < 6 { *x * factor } else { (*x * factor).min(LAST) };
                    input
                })
                .collect();
            for ((tolerance, a), b) in all.iter_mut().zip(&exact).zip(&bench.map(&rounded)) {
                *tolerance = tolerance.including(a, b);
            }
        }
    }
    all
}

/// Whether two samples differ by rounding only. Weights of grazing directions are proportional to their cosines.
fn is_same(a: &ScatteringOutput, b: &ScatteringOutput, tolerance: &Tolerance) -> bool {
    let close =
        |a: f32, b: f32, more: f32, rounding: f32| (a - b).abs() <= (1.0e-4 + more) * b.abs().max(1.0e-3) + rounding;
    let grazing = (a.wi[2] - b.wi[2]).abs() / b.wi[2].abs().max(1.0e-6);
    (a.lobe == b.lobe || tolerance.lobe)
        && (d3(a.wi) - d3(b.wi)).length() < 1.0e-5 + tolerance.wi
        && close(a.pdf, b.pdf, 0.0, tolerance.pdf)
        && close(a.value[0], b.value[0], 0.0, tolerance.value)
        && close(a.weight[0], b.weight[0], 2.0 * grazing, tolerance.weight)
}

/// Results that are not the same as `b`, each with its name: a weight, a density and a value 1 % larger, and a direction turned by 0.001.
/// Results close to 0 are left out.
fn twins(b: &ScatteringOutput) -> Vec<(&'static str, ScatteringOutput)> {
    let more = |x: [f32; 3]| x.map(|x| 1.01 * x);
    let turned = (d3(b.wi) + 0.001 * d3(b.wi).any_orthonormal_vector()).normalize().as_vec3().into();
    let is_away = b.wi[2].abs() >= 1.0e-3;
    let all = [
        ("weight", b.weight[0] >= 1.0e-3 && is_away, ScatteringOutput { weight: more(b.weight), ..*b }),
        ("density", b.pdf >= 1.0e-3, ScatteringOutput { pdf: 1.01 * b.pdf, ..*b }),
        ("value", b.value[0] >= 1.0e-3, ScatteringOutput { value: more(b.value), ..*b }),
        ("direction", b.lobe != LOBE_NONE, ScatteringOutput { wi: turned, ..*b }),
    ];
    all.into_iter().filter(|(_, counts, _)| *counts).map(|(name, _, twin)| (name, twin)).collect()
}

/// Samples of a kind do not depend on the other kinds that the pipeline contains. Compilers may round the arithmetic of two
/// pipelines differently, which the tolerance grants. Nearly all [`twins`] are found, so the tolerance is not too wide.
#[test]
fn kinds_are_the_same_alone() {
    let all = Bench::new();
    let mut numbers = Numbers::new(64);
    for (name, substance) in substances().iter().step_by(3) {
        let is_beckmann = substance.facets().is_some_and(|facets| !facets.is_ggx);
        let has_smooth_base = matches!(substance, Substance::PolarizedPlastic(_));
        let has_rough_base = substance.device().kind_and_flags & MATERIAL_ENERGY_PRESERVING != 0;
        let has_weighted_base = substance.device().kind_and_flags & MATERIAL_WEIGHTED_BASE != 0;
        let alone = Bench::with(&Variant {
            material_kinds: 1 << (substance.device().kind_and_flags & 0xff),
            surface_features: if is_beckmann { FEATURE_BECKMANN } else { 0 }
                | if has_smooth_base { FEATURE_SMOOTH_BASE } else { 0 }
                | if has_weighted_base { FEATURE_WEIGHTED_BASE } else { 0 }
                | if has_rough_base { FEATURE_ENERGY_PRESERVING } else { 0 }
                | if substance.device().film[0] > 0.0 { FEATURE_FILM } else { 0 },
            ..Variant::default()
        });
        let mut one = || {
            let u = [(); 3].map(|()| numbers.unit() as f32);
            input(substance, numbers.unit_vector(), numbers.unit_vector(), u)
        };
        let inputs: Vec<_> = (0..1024).map(|_| one()).collect();
        let results = all.map(&inputs).into_iter().zip(alone.map(&inputs));
        let tolerances = tolerances(&alone, &inputs);
        let undecided = tolerances.iter().filter(|tolerance| tolerance.lobe).count();
        assert!(undecided <= 20, "{name}: rounding decides the lobe of {undecided} of 1024 samples");
        let mut missed = Vec::new();
        let mut count = 0;
        for ((i, tolerance), (a, b)) in inputs.iter().zip(&tolerances).zip(results) {
            assert!([tolerance.pdf, tolerance.value, tolerance.weight].iter().all(|x| x.is_finite()), "{name}: {i:?}");
            assert!(is_same(&a, &b, tolerance), "{name}: {i:?}\n{a:?}\n{b:?}");
            let twins = twins(&b);
            count += twins.len();
            missed.extend(twins.iter().filter(|(_, twin)| is_same(twin, &b, tolerance)).map(|(what, _)| *what));
        }
        println!("{name}: {} of {count} twins are missed, and rounding decides {undecided} lobes", missed.len());
        assert!(count > 500 && 100 * missed.len() <= count, "{name}: of {count} twins, {missed:?} are missed");
    }
}
