//! Claim: directions that the device draws from a guide have the density of the twin, and each comes with that density.

use std::f64::consts::{PI, TAU};

use lodestar::settings::Sampler;
use support::guide_cases::{DIRECTIONS, Drawn, Guided, Setting, settings};
use support::significance::two_sided;
use support::statistics::{chi_square, mean_and_error};
use support::twins::direction_map::direction_bin;
use support::twins::guide::Guide;
use support::twins::rejection_mix::mean_tries;

use super::densities::slack;
use crate::evidence::{Evidence, Record};
use crate::rows::{Row, Scope, kind_of};
use crate::subject::Subject;
use crate::tables::tables;

const SAMPLES: usize = 1 << 16;
/// Number of normals in the short form.
const FEW_NORMALS: usize = 2;
/// Number of samples where one row is tested alone, so that the test is sharper.
const MORE_SAMPLES: usize = 1 << 18;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    scope.guided().iter().for_each(|row| test_row(subject, scope, row, evidence));
}

fn test_row(subject: &Subject, scope: Scope, row: &Row, evidence: &mut Evidence) {
    let kind = kind_of(row);
    let guided = Guided::with(kind, &subject.guide_kernels());
    let count = if scope.is_narrow() { MORE_SAMPLES } else { SAMPLES };
    let normals = if scope.full || scope.is_narrow() { usize::MAX } else { FEW_NORMALS };
    for (seed, setting) in (subject.seed..).zip(settings(kind.map).iter().take(normals)) {
        for (name, table) in tables(kind.map, setting.nb) {
            let case = format!("{}: {name}, normal {}, seed {seed}", row.name, setting.name);
            guided.fill(&table);
            let drawn = guided.draw(setting, seed, count);
            let guide = setting.guide(&table, &kind.rules, setting.entry(&table, &kind.rules));
            let (observed, expected) = setting.histogram(&drawn, &guide);
            evidence.test(format!("chi-square, {case}"), chi_square(&observed, &expected), || {
                Record::Histogram(observed.clone(), expected.clone())
            });
            check_samples(&drawn, &guide, &case, evidence);
            check_tries(&drawn, setting, &guide, &case, evidence);
            check_estimates(&drawn, setting, &case, evidence);
        }
    }
}

/// Every sample comes with the density of its direction. No sample of a rejection sampler lies below both horizons.
fn check_samples(drawn: &[Drawn], guide: &Guide, case: &str, evidence: &mut Evidence) {
    let (mut at_borders, mut wrong, mut below) = (0, 0, 0);
    for d in drawn {
        let w = d.direction();
        let rejects = matches!(guide.rules.sampler, Sampler::RejectionMix | Sampler::Rejection);
        let is_below = w.dot(guide.n).max(w.dot(guide.nb)) < -1.0e-6;
        below += usize::from(rejects && is_below);
        wrong += usize::from(d.overrun != 0 || !d.pdf.is_finite() || d.pdf < 0.0);
        let off = |pdf: f32| {
            let twin = guide.pdf(w);
            (f64::from(pdf) - twin).abs() > 1.0e-4 * twin + slack(guide, w)
        };
        if direction_bin(guide.map, w, DIRECTIONS) != d.bin {
            at_borders += 1;
        } else if w.dot(guide.n) > 1.0e-6 {
            wrong += usize::from(d.pdf <= 0.0 || off(d.pdf));
            at_borders += usize::from(off(d.pdf_of_wi));
        }
    }
    evidence
        .hold(format!("density of samples, {case}"), wrong == 0, || format!("{wrong} of {} are wrong", drawn.len()));
    evidence.hold(format!("horizon, {case}"), below == 0, || format!("{below} samples lie below both horizons"));
    let few = at_borders <= drawn.len() / 10_000;
    evidence.hold(format!("bins of samples, {case}"), few, || format!("{at_borders} samples are in another bin"));
}

/// Probability of a mean at least as far from `expected`. Rounding in single precision is no deviation.
fn surprise((mean, error): (f64, f64), expected: f64) -> f64 {
    two_sided((mean - expected) / error.hypot(1.0e-6 * expected))
}

fn check_tries(drawn: &[Drawn], setting: &Setting, guide: &Guide, case: &str, evidence: &mut Evidence) {
    if !matches!(guide.rules.sampler, Sampler::RejectionMix | Sampler::Rejection) {
        return;
    }
    let (normalizer, bound) = setting.normalizer_and_bound(guide.radiance);
    let c = if bound > 0.0 { (normalizer / (TAU * bound)).min(1.0) } else { 0.0 };
    let expected = mean_tries(c, guide.entry.uniform_share, guide.rules);
    let tries = mean_and_error(drawn.iter().map(|d| f64::from(d.tries)));
    evidence.test(format!("tries, {case}"), surprise(tries, expected), || Record::Nothing);
}

/// Samples estimate the hemisphere's solid angle and its projected solid angle, which are known.
fn check_estimates(drawn: &[Drawn], setting: &Setting, case: &str, evidence: &mut Evidence) {
    let cosine = |d: &Drawn| d.direction().dot(setting.n).max(0.0);
    let weight = |c: f64, d: &Drawn| if c > 0.0 { 1.0 / f64::from(d.pdf) } else { 0.0 };
    let solid_angle = mean_and_error(drawn.iter().map(|d| weight(cosine(d), d)));
    let projected = mean_and_error(drawn.iter().map(|d| cosine(d) * weight(cosine(d), d)));
    evidence.test(format!("solid angle, {case}"), surprise(solid_angle, TAU), || Record::Nothing);
    evidence.test(format!("projected solid angle, {case}"), surprise(projected, PI), || Record::Nothing);
}
