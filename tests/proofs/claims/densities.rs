//! Claim: the device's density of a guide equals the twin's, integrates to one over the sphere, and is positive for
//! every direction that the surface can reflect to.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use lodestar::settings::{DirectionMap, Sampler};
use support::guide_cases::{DIRECTIONS, Guided, Setting, settings};
use support::twins::direction_map::{direction_bin, sphere_to_map};
use support::twins::guide::Guide;

use crate::evidence::Evidence;
use crate::rows::{Scope, kind_of};
use crate::subject::Subject;
use crate::tables::tables;

/// Maximum deviation of the integral over the sphere from one.
const MOST_OFF: f64 = 1.0e-4;
/// The normal of the short form, at the corner of a bin: where the true normal and the representative one differ most,
/// a fault that takes one for the other shows most.
const CORNER: usize = 1;

pub fn test(subject: &Subject, scope: Scope, evidence: &mut Evidence) {
    for row in scope.guided() {
        let kind = kind_of(&row);
        let guided = Guided::with(kind, &subject.guide_kernels());
        let all = settings(kind.map);
        for setting in if scope.full { all } else { &all[CORNER..=CORNER] } {
            for (name, table) in tables(kind.map, setting.nb) {
                let case = format!("{}: {name}, normal {}", row.name, setting.name);
                guided.fill(&table);
                let guide = setting.guide(&table, &kind.rules, setting.entry(&table, &kind.rules));
                check(&guided, setting, &guide, &case, evidence);
            }
        }
    }
}

fn check(guided: &Guided, setting: &Setting, guide: &Guide, case: &str, evidence: &mut Evidence) {
    let densities = guided.densities(setting);
    let integral = 4.0 * PI * densities.iter().map(|d| f64::from(d.pdf)).sum::<f64>() / densities.len() as f64;
    evidence.hold(format!("integral, {case}"), (integral - 1.0).abs() < MOST_OFF, || format!("it is {integral:.6}"));
    let (mut unsupported, mut wrong) = (0, None);
    // Every seventh point is enough: each bin has some.
    for d in densities.iter().step_by(7) {
        let w = Vec3::from(d.wi).as_dvec3();
        let (height, guide_height) = (w.dot(guide.n), w.dot(guide.nb));
        unsupported += usize::from(height > 0.0 && d.pdf <= 0.0);
        let at_border = from_border(guide.map, w) < 1.0e-6 || height.abs() < 1.0e-6 || guide_height.abs() < 1.0e-6;
        let twin = guide.pdf(w);
        // The cosine about the representative normal is a sum of three rounded products.
        let of_cosine = if guide_height > 0.0 { 3.0e-7 / guide_height } else { 0.0 };
        let most = (1.0e-4 + of_cosine) * twin + slack(guide, w);
        if !at_border && (f64::from(d.pdf) - twin).abs() > most {
            wrong = Some((w, d.pdf, twin));
        }
    }
    evidence.hold(format!("support, {case}"), unsupported == 0, || format!("{unsupported} directions have density 0"));
    evidence.hold(format!("density, {case}"), wrong.is_none(), || format!("(direction, density, twin): {wrong:?}"));
}

/// Allowed difference between two densities. It covers rounding of the numbers that a density is made of, and
/// approximate integrals. Samples are drawn from the same numbers, so this is no bias.
pub fn slack(guide: &Guide, w: DVec3) -> f64 {
    let bin = direction_bin(guide.map, w, DIRECTIONS) as usize;
    match guide.rules.sampler {
        // Precision of a prefix sum.
        Sampler::SphereInversion => 2.0e-5,
        // The twin's points give an integral to within 3e-6 sr: see the tests of the normalizers.
        Sampler::HemisphereInversion => guide.entry.guide_scale * f64::from(guide.radiance[bin]) * 3.0e-6,
        // The cosine about the true normal is a sum of three rounded products.
        Sampler::Product => guide.cosine_share() * 3.0e-7 / PI,
        // The share of Eq. 8 is next to 0. It comes from a normalizer that is right to about 1e-6.
        _ if guide.rules.mixes_acceptances() => guide.entry.guide_scale * 4.0e-6,
        _ => 0.0,
    }
}

/// Distance in the square to the nearest border between direction bins.
fn from_border(map: DirectionMap, w: DVec3) -> f64 {
    let cells = (0.5 * sphere_to_map(map, w) + 0.5) * f64::from(DIRECTIONS);
    (cells - cells.round()).abs().min_element() * 2.0 / f64::from(DIRECTIONS)
}
