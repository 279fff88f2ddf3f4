//! The samplers that follow a guide: `glsl/include/guided_direction.glsl`

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use lodestar::layout;
use lodestar::reference::direction_map::{bin_center, direction_bin, sphere_to_map};
use lodestar::reference::guide::Guide;
use lodestar::reference::normalization_entry::{NormalizationEntry, Rules, factors_with_share, rejection_factors};
use lodestar::reference::rejection_mix::mean_tries;
use lodestar::settings::{DirectionMap, Sampler};

use crate::guide_cases::{DIRECTIONS, Drawn, Guided, Kind, MOST_SAMPLES, Setting, settings, tables};
use crate::statistics::{mean_and_error, sidak, within_four_sigma};

/// Probability that any of all chi-squares fails by chance.
const SIGNIFICANCE: f64 = 0.01;
const SAMPLES: usize = 1 << 16;

const MIX: Kind = Kind::new(Sampler::RejectionMix, 8, 1.0 / 16.0);
const ACCEPTANCE: Kind = MIX.mixing_acceptances();
const PLAIN: Kind = Kind::new(Sampler::Rejection, 15, 1.0 / 16.0);
const SPHERE: Kind = Kind::new(Sampler::SphereInversion, 1, 1.0 / 16.0);
const HEMISPHERE: Kind = Kind::new(Sampler::HemisphereInversion, 1, 1.0 / 16.0);

const PRODUCT: Kind = Kind::new(Sampler::Product, 1, 1.0 / 16.0);

/// Every sampler with every way to set it.
const ALL: [Kind; 15] = [
    MIX,
    MIX.on_cylinder(),
    MIX.with_epsilon(0.3),
    MIX.with_epsilon(1.0e-3).on_cylinder(),
    ACCEPTANCE,
    ACCEPTANCE.on_cylinder(),
    ACCEPTANCE.with_epsilon(0.05),
    PLAIN,
    SPHERE,
    SPHERE.on_cylinder(),
    HEMISPHERE,
    HEMISPHERE.on_cylinder(),
    PRODUCT,
    PRODUCT.on_cylinder(),
    PRODUCT.with_epsilon(0.5),
];

/// Those, and what differs only in its tries or least share.
fn kinds() -> Vec<Kind> {
    let tries = [1, 2, 7, 32];
    let tries = tries.iter().map(|&max_tries| Kind::new(Sampler::RejectionMix, max_tries, 1.0 / 16.0));
    let more = [
        Kind::new(Sampler::RejectionMix, 8, 0.5),
        Kind::new(Sampler::RejectionMix, 1, 0.5),
        Kind::new(Sampler::RejectionMix, 2, 0.25).mixing_acceptances(),
        Kind::new(Sampler::Rejection, 32, 0.25).on_cylinder(),
        Kind::new(Sampler::SphereInversion, 1, 0.5),
        Kind::new(Sampler::HemisphereInversion, 1, 0.5),
    ];
    ALL.into_iter().chain(tries).chain(more).collect()
}

#[test]
fn samples_follow_their_density() {
    let kinds = kinds();
    let level = sidak(SIGNIFICANCE, kinds.len() * settings(DirectionMap::EqualArea).len() * 7);
    for kind in kinds {
        let guided = Guided::new(kind);
        let mut noticed = 0;
        for (seed, setting) in (0..).zip(settings(kind.map)) {
            for (name, table) in tables(kind.map, setting.nb) {
                let case = format!("{kind:?}: {name}, {}", setting.name);
                guided.fill(&table);
                let drawn = guided.draw(setting, seed, SAMPLES);
                let guide = setting.guide(&table, &kind.rules, setting.entry(&table, &kind.rules));
                let p = setting.fit(&drawn, &guide);
                assert!(p > level, "{case}: chi-square {p}");
                check_samples(&drawn, &kind, &guide, &case);
                check_tries(&drawn, setting, &guide, &case);
                check_estimates(&drawn, setting, 1.0).unwrap_or_else(|e| panic!("{case}: {e}"));
                noticed += u32::from(check_estimates(&drawn, setting, 1.05).is_err());
            }
        }
        // All but the tables that leave the estimates so noisy that a density 5 % off is within their error.
        let least = if kind.chooses_bins() || kind.rules.epsilon.is_some() { 12 } else { 35 };
        assert!(noticed >= least, "{kind:?}: a density 5 % off was noticed {noticed} times of 35");
    }
}

/// Every sample comes with the density that its direction has, and none of rejection lies below both horizons.
fn check_samples(drawn: &[Drawn], kind: &Kind, guide: &Guide, case: &str) {
    let mut at_borders = 0;
    for d in drawn {
        let w = d.direction();
        assert!(d.overrun == 0 && d.pdf.is_finite() && d.pdf >= 0.0, "{case}: {d:?}");
        let below = w.dot(guide.n).max(w.dot(guide.nb)) < -1.0e-6;
        assert!(kind.chooses_bins() || !below, "{case}: {d:?} lies below both horizons");
        if direction_bin(guide.map, w, DIRECTIONS) != d.bin {
            at_borders += 1;
        } else if w.dot(guide.n) > 1.0e-6 {
            let twin = guide.pdf(w);
            assert!(d.pdf > 0.0 && close(d.pdf, twin, guide, w), "{case}: {d:?}, not {twin}");
            if !close(d.pdf_of_wi, twin, guide, w) {
                at_borders += 1;
            }
        }
    }
    assert!(at_borders <= drawn.len() / 10_000, "{case}: {at_borders} samples in another bin");
}

fn close(a: f32, b: f64, guide: &Guide, w: DVec3) -> bool {
    (f64::from(a) - b).abs() <= 1.0e-4 * b + slack(guide, w)
}

/// What a density may differ by because the numbers that it is made of are rounded, or integrals approximate; samples are
/// drawn from the same numbers.
fn slack(guide: &Guide, w: DVec3) -> f64 {
    let bin = direction_bin(guide.map, w, DIRECTIONS) as usize;
    match guide.rules.sampler {
        // A prefix sum's precision.
        Sampler::SphereInversion => 2.0e-5,
        // The twin's points know an integral to 3e-6 sr: see the tests of the normalizers.
        Sampler::HemisphereInversion => guide.entry.guide_scale * f64::from(guide.radiance[bin]) * 3.0e-6,
        // The cosine about the true normal is a sum of three rounded products.
        Sampler::Product => guide.cosine_share() * 3.0e-7 / PI,
        // The share of Eq. 8: next to 0, from a normalizer that is right to some 1e-6.
        _ if guide.rules.mixes_acceptances() => guide.entry.guide_scale * 4.0e-6,
        _ => 0.0,
    }
}

fn check_tries(drawn: &[Drawn], setting: &Setting, guide: &Guide, case: &str) {
    let tries = mean_and_error(drawn.iter().map(|d| f64::from(d.tries)));
    if !matches!(guide.rules.sampler, Sampler::RejectionMix | Sampler::Rejection) {
        let expected = 1.0 - guide.cosine_share();
        return assert!(within_four_sigma(tries, expected), "{case}: {tries:?}, not {expected} tries");
    }
    let (normalizer, bound) = setting.normalizer_and_bound(guide.radiance);
    let c = if bound > 0.0 { (normalizer / (TAU * bound)).min(1.0) } else { 0.0 };
    let expected = |max_tries| {
        let rules = Rules { max_tries, ..*guide.rules };
        mean_tries(c, guide.entry.uniform_share, &rules)
    };
    let max_tries = guide.rules.max_tries;
    assert!(within_four_sigma(tries, expected(max_tries)), "{case}: {tries:?}, not {} tries", expected(max_tries));
    assert!(drawn.iter().all(|d| (1..=max_tries + 1).contains(&d.tries)), "{case}");
    // Where a try more would change the mean by several percent, it must be noticed.
    if expected(max_tries + 1) > 1.05 * expected(max_tries) {
        assert!(!within_four_sigma(tries, expected(max_tries + 1)), "{case}: a try more");
    }
}

/// Estimates of the hemisphere's solid angle and of its projection, dividing by `tamper` times the density.
fn check_estimates(drawn: &[Drawn], setting: &Setting, tamper: f64) -> Result<(), String> {
    let cosine = |d: &Drawn| d.direction().dot(setting.n).max(0.0);
    let weight = |c: f64, d: &Drawn| if c > 0.0 { 1.0 / (tamper * f64::from(d.pdf)) } else { 0.0 };
    let solid_angle = mean_and_error(drawn.iter().map(|d| weight(cosine(d), d)));
    let projected = mean_and_error(drawn.iter().map(|d| cosine(d) * weight(cosine(d), d)));
    if !within_four_sigma(solid_angle, TAU) {
        return Err(format!("solid angle {solid_angle:?}"));
    }
    if !within_four_sigma(projected, PI) {
        return Err(format!("projected {projected:?}"));
    }
    Ok(())
}

#[test]
fn densities_are_the_twins_positive_and_integrate_to_one() {
    for kind in ALL {
        let guided = Guided::new(kind);
        for setting in settings(kind.map) {
            for (name, table) in tables(kind.map, setting.nb) {
                let case = format!("{kind:?}: {name}, {}", setting.name);
                guided.fill(&table);
                let guide = setting.guide(&table, &kind.rules, setting.entry(&table, &kind.rules));
                check_densities(&guided, setting, &guide, &case);
            }
        }
    }
}

fn check_densities(guided: &Guided, setting: &Setting, guide: &Guide, case: &str) {
    let densities = guided.densities(setting);
    let mean = densities.iter().map(|d| f64::from(d.pdf)).sum::<f64>() / densities.len() as f64;
    assert!((4.0 * PI * mean - 1.0).abs() < 1.0e-4, "{case}: the integral is {}", 4.0 * PI * mean);
    // Enough of them, in every bin.
    for d in densities.iter().step_by(7) {
        let w = Vec3::from(d.wi).as_dvec3();
        let (height, guide_height) = (w.dot(guide.n), w.dot(guide.nb));
        assert!(height <= 0.0 || d.pdf > 0.0, "{case}: no support at {w}");
        let at_border = from_border(guide.map, w) < 1.0e-6 || height.abs() < 1.0e-6 || guide_height.abs() < 1.0e-6;
        if !at_border {
            let twin = guide.pdf(w);
            // The cosine about the representative normal is a sum of three rounded products.
            let of_cosine = if guide_height > 0.0 { 3.0e-7 / guide_height } else { 0.0 };
            let difference = (f64::from(d.pdf) - twin).abs();
            let most = (1.0e-4 + of_cosine) * twin + slack(guide, w);
            assert!(difference <= most, "{case}: {}, not {twin} at {w}", d.pdf);
        }
    }
}

/// Distance in the square from the next border between direction bins.
fn from_border(map: DirectionMap, w: DVec3) -> f64 {
    let cells = (0.5 * sphere_to_map(map, w) + 0.5) * f64::from(DIRECTIONS);
    (cells - cells.round()).abs().min_element() * 2.0 / f64::from(DIRECTIONS)
}

#[test]
fn twins_are_rejected() {
    for kind in ALL {
        let setting = &settings(kind.map)[1];
        let all = tables(kind.map, setting.nb);
        let (table, rules) = (&all[1].1, &kind.rules);
        let guided = Guided::new(kind);
        guided.fill(table);
        let drawn = guided.draw(setting, 77, MOST_SAMPLES);
        let fit = |entry: NormalizationEntry| setting.fit(&drawn, &setting.guide(table, rules, entry));
        let reject = |what: &str, p: f64| assert!(p < 1.0e-6, "{kind:?}: {what}: {p}");
        let entry = setting.entry(table, rules);
        let right = fit(entry);
        assert!(right > SIGNIFICANCE / ALL.len() as f64, "{kind:?}: {right}");
        reject("a guide 5 % off", fit(NormalizationEntry { guide_scale: 1.05 * entry.guide_scale, ..entry }));
        let least_share = Rules {
            min_uniform_share: 1.5 * rules.min_uniform_share,
            epsilon: rules.epsilon.map(|epsilon| 1.5 * epsilon),
            ..*rules
        };
        // Elsewhere it is Eq. 8 that decides, or the fallback hides a share of a thousandth.
        let decides = !matches!(kind.rules.sampler, Sampler::RejectionMix | Sampler::Product);
        let matters = decides || kind.rules.epsilon.is_some_and(|e| e > 0.01);
        if matters {
            reject("another share", fit(setting.entry(table, &least_share)));
        }
        // That of the product sampler is the weights of the table, not factors.
        if kind.rules.sampler != Sampler::Product {
            reject("the entry of another table", fit(setting.entry(&all[3].1, rules)));
        }
        let elsewhere = setting.guide(&all[3].1, rules, setting.entry(&all[3].1, rules));
        reject("another table", setting.fit(&drawn, &elsewhere));
        // The density of another normal whose representative is the same one.
        let other = Setting::new(kind.map, "center of that bin", setting.nb);
        reject("another normal", other.fit(&drawn, &other.guide(table, rules, entry)));
        // What the last step left behind.
        guided.cell.radiance.upload(0, &all[3].1).expect("uploaded");
        reject("a stale guide", setting.fit(&guided.draw(setting, 78, MOST_SAMPLES), &elsewhere));
    }
}

#[test]
fn twins_of_the_share_and_of_the_tries_are_rejected() {
    let setting = &settings(DirectionMap::EqualArea)[1];
    let all = tables(DirectionMap::EqualArea, setting.nb);
    let table = &all[1].1;
    let (normalizer, bound) = setting.normalizer_and_bound(table);
    for kind in [2, 32].map(|tries| Kind::new(Sampler::RejectionMix, tries, 1.0 / 16.0)) {
        for kind in [kind, kind.mixing_acceptances()] {
            let guided = Guided::new(kind);
            guided.fill(table);
            let drawn = guided.draw(setting, 77, MOST_SAMPLES);
            let fit = |share, max_tries| {
                let rules = Rules { max_tries, ..kind.rules };
                let entry = factors_with_share(normalizer, bound, share, &rules);
                setting.fit(&drawn, &setting.guide(table, &kind.rules, entry))
            };
            let share = setting.entry(table, &kind.rules).uniform_share;
            let tries = kind.rules.max_tries;
            assert!(fit(share, tries) > SIGNIFICANCE / 4.0, "{kind:?}: {}", fit(share, tries));
            // Many tries hide one more; few hide all else, for nearly all samples fall back.
            let (what, p) =
                if tries == 2 { ("a try more", fit(share, 3)) } else { ("a share 5 % off", fit(1.05 * share, tries)) };
            assert!(p < 1.0e-6, "{kind:?}: {what}: {p}");
        }
    }
}

#[test]
fn entries_that_do_not_fit_the_table_are_rejected() {
    let kind = Kind::new(Sampler::RejectionMix, 32, 1.0 / 16.0);
    let guided = Guided::new(kind);
    let setting = &settings(kind.map)[1];
    let all = tables(kind.map, setting.nb);
    let device_entry = |e: NormalizationEntry| layout::NormalizationEntry {
        guide_scale: e.guide_scale as f32,
        uniform_density: e.uniform_density as f32,
        acceptance_scale: e.acceptance_scale as f32,
        uniform_share: e.uniform_share as f32,
    };
    let fit = |table: &[f32], entry: NormalizationEntry| {
        guided.fill(table);
        guided.cell.set_entry(setting.normal_bin, device_entry(entry));
        setting.fit(&guided.draw(setting, 5, MOST_SAMPLES), &setting.guide(table, &kind.rules, entry))
    };
    for (name, table) in &all {
        let right = fit(table, setting.entry(table, &kind.rules));
        assert!(right > SIGNIFICANCE / 7.0, "{name}, with the right entry: {right}");
    }
    let (peaked, horizon, noisy) = (&all[1].1, &all[2].1, &all[3].1);
    let stale = fit(peaked, setting.entry(noisy, &kind.rules));
    assert!(stale < 1.0e-9, "last step's normalizer: {stale}");
    // A maximum over the centers of bins is too low wherever radiance lies beside them.
    let (normalizer, _) = setting.normalizer_and_bound(horizon);
    let centers =
        (0..).zip(horizon).map(|(bin, &l)| f64::from(l) * bin_center(kind.map, bin, DIRECTIONS).dot(setting.nb));
    let clipped = fit(horizon, rejection_factors(normalizer, centers.fold(0.0, f64::max), &kind.rules));
    assert!(clipped < 1.0e-9, "a maximum over centers: {clipped}");
}
