//! `glsl/include/rejection_mix.glsl`

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use lodestar::layout;
use lodestar::reference::equal_area::{bin_center, sphere_to_square, square_bin};
use lodestar::reference::normalization_entry::{NormalizationEntry, factors_with_share, normalization_factors};
use lodestar::reference::rejection_mix::{mean_tries, pdf_rejection_mix};

use crate::rejection_cases::{DIRECTIONS, Drawn, MOST_SAMPLES, Rejection, Setting, settings, tables};
use crate::statistics::{mean_and_error, sidak, within_four_sigma};

/// Probability that any of all chi-squares fails by chance.
const SIGNIFICANCE: f64 = 0.01;
const MAX_TRIES: [u32; 5] = [1, 2, 7, 8, 32];
const MIN_UNIFORM_SHARES: [f32; 2] = [1.0 / 16.0, 0.5];
const SAMPLES: usize = 1 << 16;

#[test]
fn samples_follow_their_density() {
    let level = sidak(SIGNIFICANCE, MAX_TRIES.len() * MIN_UNIFORM_SHARES.len() * settings().len() * 6);
    for max_tries in MAX_TRIES {
        for share in MIN_UNIFORM_SHARES {
            let rejection = Rejection::new(max_tries, share);
            for (seed, setting) in (0..).zip(settings()) {
                for (name, table) in tables(setting.nb) {
                    let case = format!("{name}, {}, {max_tries} tries, share {share}", setting.name);
                    rejection.fill(&table);
                    let drawn = rejection.draw(setting, seed, SAMPLES);
                    let entry = setting.entry(&table, rejection.limits);
                    let p = setting.fit(&drawn, &table, &entry);
                    assert!(p > level, "{case}: chi-square {p}");
                    check_samples(&drawn, setting, &table, &entry, &case);
                    check_tries(&drawn, setting, &table, &rejection, &case);
                    check_estimates(&drawn, setting, 1.0).unwrap_or_else(|e| panic!("{case}: {e}"));
                    assert!(check_estimates(&drawn, setting, 1.05).is_err(), "{case}: a density 5 % off");
                }
            }
        }
    }
}

/// Every sample lies above one of the two horizons and comes with the density that its direction has.
fn check_samples(drawn: &[Drawn], setting: &Setting, table: &[f32], entry: &NormalizationEntry, case: &str) {
    let mut at_borders = 0;
    for d in drawn {
        let w = d.direction();
        assert!(d.overrun == 0 && (f64::from(d.pdf) > 0.0) && d.pdf.is_finite(), "{case}: {d:?}");
        assert!(w.dot(setting.n).max(w.dot(setting.nb)) > -1.0e-6, "{case}: {d:?} lies below both horizons");
        if square_bin(sphere_to_square(w), DIRECTIONS) != d.bin {
            at_borders += 1;
        } else if w.dot(setting.n) > 1.0e-6 {
            let twin = pdf_rejection_mix(table, DIRECTIONS, setting.nb, setting.n, w, entry);
            assert!(close(d.pdf, twin), "{case}: {d:?}, not {twin}");
            if !close(d.pdf_of_wi, twin) {
                at_borders += 1;
            }
        }
    }
    assert!(at_borders <= drawn.len() / 10_000, "{case}: {at_borders} samples in another bin");
}

fn close(a: f32, b: f64) -> bool {
    (f64::from(a) / b - 1.0).abs() < 1.0e-4
}

fn check_tries(drawn: &[Drawn], setting: &Setting, table: &[f32], rejection: &Rejection, case: &str) {
    let (normalizer, bound) = setting.normalizer_and_bound(table);
    let share = setting.entry(table, rejection.limits).uniform_share;
    let max_tries = rejection.limits.max_tries;
    let expected = |max_tries| mean_tries((normalizer / (TAU * bound)).min(1.0), share, max_tries);
    let tries = mean_and_error(drawn.iter().map(|d| f64::from(d.tries)));
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
    let estimates = |f: fn(f64) -> f64| drawn.iter().map(move |d| f(cosine(d)) / (tamper * f64::from(d.pdf)));
    let solid_angle = mean_and_error(estimates(|c| if c > 0.0 { 1.0 } else { 0.0 }));
    let projected = mean_and_error(estimates(|c| c));
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
    let rejection = Rejection::new(8, 1.0 / 16.0);
    for setting in settings() {
        for (name, table) in tables(setting.nb) {
            let case = format!("{name}, {}", setting.name);
            rejection.fill(&table);
            let entry = setting.entry(&table, rejection.limits);
            let densities = rejection.densities(setting);
            let mean = densities.iter().map(|d| f64::from(d.pdf)).sum::<f64>() / densities.len() as f64;
            assert!((4.0 * PI * mean - 1.0).abs() < 1.0e-4, "{case}: the integral is {}", 4.0 * PI * mean);
            for d in &densities {
                let w = Vec3::from(d.wi).as_dvec3();
                let (height, guide_height) = (w.dot(setting.n), w.dot(setting.nb));
                assert!(height <= 0.0 || d.pdf > 0.0, "{case}: no support at {w}");
                let at_border = from_border(w) < 1.0e-6 || height.abs() < 1.0e-6 || guide_height.abs() < 1.0e-6;
                if !at_border {
                    let twin = pdf_rejection_mix(&table, DIRECTIONS, setting.nb, setting.n, w, &entry);
                    // The cosine about the representative normal is a sum of three rounded products.
                    let of_cosine = if guide_height > 0.0 { 3.0e-7 / guide_height } else { 0.0 };
                    let difference = (f64::from(d.pdf) - twin).abs();
                    assert!(difference <= (1.0e-4 + of_cosine) * twin, "{case}: {}, not {twin} at {w}", d.pdf);
                }
            }
        }
    }
}

/// Distance in the square from the next border between direction bins.
fn from_border(w: DVec3) -> f64 {
    let cells = (0.5 * sphere_to_square(w) + 0.5) * f64::from(DIRECTIONS);
    (cells - cells.round()).abs().min_element() * 2.0 / f64::from(DIRECTIONS)
}

#[test]
fn twins_are_rejected() {
    let setting = &settings()[1];
    let all = tables(setting.nb);
    let table = &all[1].1;
    for max_tries in [2, 32] {
        let rejection = Rejection::new(max_tries, 1.0 / 16.0);
        rejection.fill(table);
        let drawn = rejection.draw(setting, 77, MOST_SAMPLES);
        let fit = |entry: &NormalizationEntry| setting.fit(&drawn, table, entry);
        let reject = |what: &str, entry: NormalizationEntry| assert!(fit(&entry) < 1.0e-6, "{what}: {}", fit(&entry));
        let entry = setting.entry(table, rejection.limits);
        assert!(fit(&entry) > SIGNIFICANCE, "{}", fit(&entry));
        let (normalizer, bound) = setting.normalizer_and_bound(table);
        let share = entry.uniform_share;
        if max_tries == 2 {
            // Many tries hide one more; few hide all else, for nearly all samples fall back.
            reject("a try more", factors_with_share(normalizer, bound, share, 3));
            continue;
        }
        reject("uniform share 5 % off", factors_with_share(normalizer, bound, 1.05 * share, max_tries));
        reject("normalizer 5 % off", NormalizationEntry { guide_scale: 1.05 * entry.guide_scale, ..entry });
        reject("the entry of another table", setting.entry(&all[3].1, rejection.limits));
        // The density of another normal whose representative is the same one.
        let other = Setting::new("center of that bin", setting.nb);
        let p = other.fit(&drawn, table, &entry);
        assert!(p < 1.0e-6, "another normal: {p}");
    }
}

#[test]
fn entries_that_do_not_fit_the_table_are_rejected() {
    let rejection = Rejection::new(32, 1.0 / 16.0);
    let setting = &settings()[1];
    let all = tables(setting.nb);
    let device_entry = |e: NormalizationEntry| layout::NormalizationEntry {
        guide_scale: e.guide_scale as f32,
        uniform_density: e.uniform_density as f32,
        acceptance_scale: e.acceptance_scale as f32,
        uniform_share: e.uniform_share as f32,
    };
    let fit = |table: &[f32], entry: NormalizationEntry| {
        rejection.fill(table);
        rejection.cell.set_entry(setting.normal_bin, device_entry(entry));
        setting.fit(&rejection.draw(setting, 5, MOST_SAMPLES), table, &entry)
    };
    for (name, table) in &all {
        let right = fit(table, setting.entry(table, rejection.limits));
        assert!(right > SIGNIFICANCE / 6.0, "{name}, with the right entry: {right}");
    }
    let (peaked, horizon, noisy) = (&all[1].1, &all[2].1, &all[3].1);
    let stale = fit(peaked, setting.entry(noisy, rejection.limits));
    assert!(stale < 1.0e-9, "last step's normalizer: {stale}");
    // A maximum over the centers of bins is too low wherever radiance lies beside them.
    let (normalizer, _) = setting.normalizer_and_bound(horizon);
    let centers = (0..).zip(horizon).map(|(bin, &l)| f64::from(l) * bin_center(bin, DIRECTIONS).dot(setting.nb));
    let clipped = fit(horizon, normalization_factors(normalizer, centers.fold(0.0, f64::max), rejection.limits));
    assert!(clipped < 1.0e-9, "a maximum over centers: {clipped}");
}
