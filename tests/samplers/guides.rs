//! Twins with slight faults must fail: samples that follow a guide
//! (`glsl/include/guide/samplers/guided_direction.glsl`) do not have their densities. `tests/proofs` claims that
//! samples have the densities of the right twins.

use lodestar::generated::layout;
use lodestar::math::direction_map::bin_center;
use lodestar::settings::{DirectionMap, Sampler};
use support::guide_cases::{DIRECTIONS, Guided, Kind, MOST_SAMPLES, Setting, settings, tables};
use support::tier;
use support::twins::normalization_entry::{NormalizationEntry, Rules, factors_with_share, rejection_factors};

/// Probability that any of the right twins is rejected by chance.
const SIGNIFICANCE: f64 = 0.01;

const MIX: Kind = Kind::new(Sampler::RejectionMix, 8, 1.0 / 16.0);
const ACCEPTANCE: Kind = MIX.mixing_acceptances();
const PLAIN: Kind = Kind::new(Sampler::Rejection, 15, 1.0 / 16.0);
const SPHERE: Kind = Kind::new(Sampler::SphereInversion, 1, 1.0 / 16.0);
const HEMISPHERE: Kind = Kind::new(Sampler::HemisphereInversion, 1, 1.0 / 16.0);

const PRODUCT: Kind = Kind::new(Sampler::Product, 1, 1.0 / 16.0);

/// All samplers that follow a guide, with all ways to set them.
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

/// Samples do not fit the densities of wrong guides. The quick tier has a sampler by rejection and the default.
#[test]
fn twins_are_rejected() {
    let kinds = if tier::is_full() { ALL.to_vec() } else { vec![ALL[0], PRODUCT] };
    for kind in kinds {
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
        // In other cases, Eq. 8 sets the share, or the fallback hides a share of a thousandth.
        let decides = !matches!(kind.rules.sampler, Sampler::RejectionMix | Sampler::Product);
        let matters = decides || kind.rules.epsilon.is_some_and(|e| e > 0.01);
        if matters {
            reject("another share", fit(setting.entry(table, &least_share)));
        }
        // The product sampler's entry holds the weights of the table, not factors.
        if kind.rules.sampler != Sampler::Product {
            reject("the entry of another table", fit(setting.entry(&all[3].1, rules)));
        }
        let elsewhere = setting.guide(&all[3].1, rules, setting.entry(&all[3].1, rules));
        reject("another table", setting.fit(&drawn, &elsewhere));
        // A twin with another normal of the same normal bin, so with the same representative normal.
        let other = Setting::new(kind.map, "center of that bin", setting.nb);
        reject("another normal", other.fit(&drawn, &other.guide(table, rules, entry)));
        // The twin of a stale guide: the radiance is new, the factors are those of the step before.
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
            // Many tries hide one try more. With few tries nearly all samples fall back, which hides everything else.
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
    // A maximum over the centers of bins is too low if a bin has radiance off its center.
    let (normalizer, _) = setting.normalizer_and_bound(horizon);
    let centers =
        (0..).zip(horizon).map(|(bin, &l)| f64::from(l) * bin_center(kind.map, bin, DIRECTIONS).dot(setting.nb));
    let clipped = fit(horizon, rejection_factors(normalizer, centers.fold(0.0, f64::max), &kind.rules));
    assert!(clipped < 1.0e-9, "a maximum over centers: {clipped}");
}
