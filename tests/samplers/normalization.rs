//! Factors of `glsl/include/guide/normalization/normalization_entry.glsl`, and the integrals that they are made from.

use std::f64::consts::TAU;

use glam::DVec3;
use lodestar::encode::cosine_integrals::cosine_integrals;
use lodestar::generated::kernels::{SAMPLER_REJECTION_MIX, Variant};
use lodestar::generated::layout;
use lodestar::math::direction_map::{bin_center, representative_normal};
use lodestar::settings::{DirectionMap, Mix, Sampler};
use support::device::{Cell, Device};
use support::guide_cases::variant;
use support::statistics::{Numbers, sphere};
use support::tier;
use support::twins::normalization_entry::{
    NormalizationEntry, Rules, inversion_factors, normalizer_and_bound, rejection_factors,
};

/// Units of a stored share: `SHARE_UNITS` in GLSL.
const SHARE_UNITS: u32 = 1 << 31;

/// Radiance tables of growing contrast, and one with light in a single bin.
fn tables(bins: u32) -> Vec<Vec<f32>> {
    let mut numbers = Numbers::new(41);
    let mut noisy = |decades: f64| (0..bins).map(|_| 10_f64.powf(numbers.between(-decades, 0.0)) as f32).collect();
    let hot = |at: u32| (0..bins).map(|bin| if bin == at { 64.0 } else { 1.0 / 64.0 }).collect();
    vec![vec![1.0; bins as usize], noisy(1.0), noisy(6.0), hot(3), hot(bins / 2 + 5)]
}

/// Largest relative difference between any of the factors. For small shares the difference is absolute.
fn difference(ours: &layout::NormalizationEntry, twin: &NormalizationEntry) -> f64 {
    let pairs = [
        (ours.guide_scale, twin.guide_scale),
        (ours.uniform_density, twin.uniform_density),
        (ours.acceptance_scale, twin.acceptance_scale),
    ];
    let relative = pairs.map(|(a, b)| (f64::from(a) / b - 1.0).abs()).into_iter().fold(0.0, f64::max);
    // Eq. 8 gives shares next to 0 with the rounding error of numbers next to 1.
    relative.max((f64::from(ours.uniform_share) - twin.uniform_share).abs() / twin.uniform_share.max(0.0625))
}

struct Case {
    directions: u32,
    normals: u32,
    map: DirectionMap,
    rules: Rules,
}

fn cases() -> Vec<Case> {
    let rules = |sampler, mix, max_tries, min_uniform_share| Rules {
        sampler,
        mix,
        epsilon: None,
        max_tries,
        min_uniform_share,
    };
    let density = |max_tries, share| rules(Sampler::RejectionMix, Mix::Density, max_tries, share);
    let case = |directions, normals, map, rules| Case { directions, normals, map, rules };
    let (square, cylinder) = (DirectionMap::EqualArea, DirectionMap::Cylindrical);
    vec![
        case(8, 8, square, density(32, 0.0625)),
        case(8, 16, square, density(1, 0.5)),
        case(16, 8, square, density(7, 0.0625)),
        case(16, 16, square, density(32, 0.0625)),
        case(32, 16, square, density(2, 0.0625)),
        case(32, 8, square, density(32, 0.5)),
        case(16, 16, cylinder, density(32, 0.0625)),
        case(16, 8, cylinder, rules(Sampler::Rejection, Mix::Density, 15, 0.0625)),
        case(16, 16, square, rules(Sampler::RejectionMix, Mix::Acceptance, 15, 0.0625)),
        case(16, 8, square, Rules { epsilon: Some(0.3), ..rules(Sampler::RejectionMix, Mix::Acceptance, 2, 0.125) }),
        case(16, 8, square, Rules { epsilon: Some(0.01), ..density(15, 0.0625) }),
        case(16, 16, square, rules(Sampler::HemisphereInversion, Mix::Density, 15, 0.0625)),
        case(16, 8, cylinder, rules(Sampler::HemisphereInversion, Mix::Density, 15, 0.5)),
    ]
}

/// Entries are their twins for every normal. The quick tier has three cases.
#[test]
fn entries_are_their_twins_for_every_normal() {
    tier::some_of(&cases(), 3).iter().for_each(check_entries);
}

fn check_entries(case: &Case) {
    let &Case { directions, normals, map, rules } = case;
    let variant = Variant { direction_resolution: directions, normal_resolution: normals, ..variant(&rules, map) };
    let device = Device::new();
    let cell = Cell::new(&device, &variant);
    let tables = tables(directions * directions);
    let filled: Vec<_> = tables
        .iter()
        .map(|table| {
            cell.fill(&device, table);
            cell.entries()
        })
        .collect();
    let bounds = cosine_integrals(map, directions, normals);
    let count = (normals * normals) as usize;
    let mut worst = [0.0_f64; 5];
    for normal in 0..count {
        let nb = representative_normal(normal as u32, normals);
        let of_normal = || bounds.iter().skip(normal).step_by(count);
        let integrals: Vec<_> = of_normal().map(|c| f64::from(c.integral)).collect();
        check_integrals(map, &integrals, directions, nb);
        let maxima: Vec<_> = of_normal().map(|c| f64::from(c.maximum)).collect();
        for (index, (table, entries)) in tables.iter().zip(&filled).enumerate() {
            let (normalizer, bound) = normalizer_and_bound(table, &integrals, &maxima);
            let twin = |normalizer| match rules.sampler {
                Sampler::HemisphereInversion => inversion_factors(normalizer, table.len(), &rules),
                _ => rejection_factors(normalizer, bound, &rules),
            };
            // 1 - (1 - c)^K cancels where c is small, and c itself is rounded next to 1.
            let cancelled = match rules.sampler {
                Sampler::HemisphereInversion => 0.0,
                _ => 6.0e-8 / rules.accepted(normalizer / (TAU * bound), twin(normalizer).uniform_share),
            };
            worst[index] = worst[index].max(difference(&entries[normal], &twin(normalizer)) - cancelled);
            // With few tries and a sharp peak the normalizer hardly matters, so only the flat table can find the fault.
            assert!(
                index > 0 || difference(&entries[normal], &twin(1.05 * normalizer)) > 1.0e-3,
                "a normalizer 5 % off"
            );
        }
    }
    // The tolerance is that of a sum of up to a thousand numbers in single precision.
    assert!(
        worst.iter().all(|&error| error < 2.0e-5),
        "{rules:?}, {map:?}, {directions} directions, {normals} normals: {worst:?}"
    );
}

/// Compares the integrals that the renderer uploads, which run along the borders of bins, with sums over points.
/// Against 100 times as many points, the sums err by up to 3.4e-7 sr in a bin of the square's 16^2. The error grows
/// with the length of the horizon in a bin. At the cylinder's poles, where points are 0.06 rad apart, it is up to
/// 2.6e-6 sr.
fn check_integrals(map: DirectionMap, integrals: &[f64], directions: u32, nb: DVec3) {
    let error = match map {
        DirectionMap::EqualArea => 4.0e-7,
        DirectionMap::Cylindrical => 3.0e-6,
    } * 16.0
        / f64::from(directions);
    for (bin, (found, expected)) in integrals.iter().zip(sphere(map).cosine_integrals(directions, nb)).enumerate() {
        assert!((found - expected).abs() < error, "{map:?}, bin {bin} of {directions}^2: {found}, not {expected}");
    }
}

#[test]
fn bin_ends_count_the_radiance_before_them() {
    for (directions, map) in
        [(16, DirectionMap::EqualArea), (6, DirectionMap::Cylindrical), (33, DirectionMap::EqualArea)]
    {
        let bins = directions * directions;
        let rules = Rules {
            sampler: Sampler::SphereInversion,
            mix: Mix::Density,
            epsilon: None,
            max_tries: 1,
            min_uniform_share: 0.25,
        };
        let variant = Variant { direction_resolution: directions, normal_resolution: 1, ..variant(&rules, map) };
        let device = Device::new();
        let cell = Cell::new(&device, &variant);
        for table in tables(bins) {
            cell.fill(&device, &table);
            let ends: Vec<u32> = cell.bin_ends.read(0, bins as usize).expect("read");
            assert!(ends.is_sorted(), "{directions}: {ends:?}");
            assert_eq!(ends.last(), Some(&SHARE_UNITS), "a unit that no bin holds");
            let total: f64 = table.iter().map(|&l| f64::from(l)).sum();
            let mut sum = 0.0;
            for (&end, &l) in ends.iter().zip(&table) {
                sum += f64::from(l);
                let share = f64::from(end) / f64::from(SHARE_UNITS);
                assert!((share - sum / total).abs() < 2.0e-6, "{directions}: {share}, not {}", sum / total);
            }
            let entry = cell.entries()[0];
            let twin = inversion_factors(f64::from(SHARE_UNITS), bins as usize, &rules);
            assert!(difference(&entry, &twin) < 1.0e-6, "{entry:?}, not {twin:?}");
        }
    }
}

#[test]
fn bounds_are_no_lower_than_any_cosine() {
    let (directions, normals) = (16, 16);
    let bounds = cosine_integrals(DirectionMap::EqualArea, directions, normals);
    let count = normals * normals;
    for normal in (0..count).step_by(5) {
        let n = representative_normal(normal, normals);
        let centers =
            (0..directions * directions).map(|bin| bin_center(DirectionMap::EqualArea, bin, directions).dot(n));
        let mut below_bound = 0;
        for (bin, center) in (0..).zip(centers) {
            let bound = f64::from(bounds[(bin * count + normal) as usize].maximum);
            assert!(bound >= center - 1.0e-7, "normal {normal}, bin {bin}");
            below_bound += u32::from(center < bound);
        }
        // The twin must fail: a maximum over centers is too low nearly everywhere above the horizon.
        assert!(below_bound > directions * directions / 3);
    }
}

#[test]
fn a_device_fills_whatever_the_radiance() {
    // No factor may be NaN, zero or negative: the sampler would lose support.
    let (device, variant) = (Device::new(), Variant { sampler: SAMPLER_REJECTION_MIX, ..Variant::default() });
    let cell = Cell::new(&device, &variant);
    for level in [1.0e-36_f32, 1.0e-30, 1.0, 1.0e30, 1.0e36] {
        cell.fill(&device, &[level; 256]);
        for entry in cell.entries() {
            let numbers = [entry.guide_scale, entry.uniform_density, entry.acceptance_scale, entry.uniform_share];
            assert!(numbers.iter().all(|x| x.is_finite() && *x > 0.0), "{level}: {entry:?}");
        }
    }
}
