//! `glsl/include/normalization_entry.glsl` and the integrals that it reads

use lodestar::cosine_integrals::cosine_integrals;
use lodestar::kernels::Variant;
use lodestar::layout;
use lodestar::reference::equal_area::bin_center;
use lodestar::reference::normalization_entry::{
    Limits, NormalizationEntry, normalization_factors, normalizer_and_bound,
};

use crate::device::{Cell, Device};
use crate::statistics::{Numbers, sphere};

/// Radiance of growing contrast, and a cell that only one bin lights.
fn tables(bins: u32) -> Vec<Vec<f32>> {
    let mut numbers = Numbers::new(41);
    let mut noisy = |decades: f64| (0..bins).map(|_| 10_f64.powf(numbers.between(-decades, 0.0)) as f32).collect();
    let hot = |at: u32| (0..bins).map(|bin| if bin == at { 64.0 } else { 1.0 / 64.0 }).collect();
    vec![vec![1.0; bins as usize], noisy(1.0), noisy(6.0), hot(3), hot(bins / 2 + 5)]
}

/// The largest relative difference between any of the factors.
fn difference(ours: &layout::NormalizationEntry, twin: &NormalizationEntry) -> f64 {
    let pairs = [
        (ours.guide_scale, twin.guide_scale),
        (ours.uniform_density, twin.uniform_density),
        (ours.acceptance_scale, twin.acceptance_scale),
        (ours.uniform_share, twin.uniform_share),
    ];
    pairs.map(|(a, b)| (f64::from(a) / b - 1.0).abs()).into_iter().fold(0.0, f64::max)
}

#[test]
fn entries_are_their_twins_for_every_normal() {
    for (directions, normals, max_tries, share) in [
        (8, 8, 32, 0.0625),
        (8, 16, 1, 0.5),
        (16, 8, 7, 0.0625),
        (16, 16, 32, 0.0625),
        (32, 16, 2, 0.0625),
        (32, 8, 32, 0.5),
    ] {
        let variant = Variant {
            direction_resolution: directions,
            normal_resolution: normals,
            max_tries,
            min_uniform_share: share,
            ..Variant::default()
        };
        let limits = Limits { max_tries, min_uniform_share: f64::from(share) };
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
        let bounds = cosine_integrals(directions, normals);
        let count = (normals * normals) as usize;
        let mut worst = [0.0_f64; 5];
        for normal in 0..count {
            let integrals = sphere().cosine_integrals(directions, bin_center(normal as u32, normals));
            let maxima: Vec<_> = bounds.iter().skip(normal).step_by(count).map(|c| f64::from(c.maximum)).collect();
            for (index, (table, entries)) in tables.iter().zip(&filled).enumerate() {
                let (normalizer, bound) = normalizer_and_bound(table, &integrals, &maxima);
                let twin = normalization_factors(normalizer, bound, limits);
                worst[index] = worst[index].max(difference(&entries[normal], &twin));
                // With few tries and a sharp peak the normalizer hardly matters, so the flat table must tell.
                let stale = normalization_factors(normalizer * 1.05, bound, limits);
                assert!(index > 0 || difference(&entries[normal], &stale) > 1.0e-3, "a normalizer 5 % off");
            }
        }
        // Where one bin outshines all others and the horizon leaves a sliver of it, neither quadrature is as good.
        let tolerance = [2.0e-5, 2.0e-5, 2.0e-5, 5.0e-5, 5.0e-5];
        let within = worst.iter().zip(tolerance).all(|(&error, tolerance)| error < tolerance);
        assert!(within, "{directions} directions, {normals} normals: {worst:?}");
    }
}

#[test]
fn bounds_are_no_lower_than_any_cosine() {
    let (directions, normals) = (16, 16);
    let bounds = cosine_integrals(directions, normals);
    let count = normals * normals;
    for normal in (0..count).step_by(5) {
        let n = bin_center(normal, normals);
        let centers = (0..directions * directions).map(|bin| bin_center(bin, directions).dot(n));
        let mut below_bound = 0;
        for (bin, center) in (0..).zip(centers) {
            let bound = f64::from(bounds[(bin * count + normal) as usize].maximum);
            assert!(bound >= center - 1.0e-7, "normal {normal}, bin {bin}");
            below_bound += u32::from(center < bound);
        }
        // The twin, a maximum over centers, would be too low nearly everywhere above the horizon.
        assert!(below_bound > directions * directions / 3);
    }
}

#[test]
fn a_device_fills_whatever_the_radiance() {
    // No entry may become NaN, zero or negative: that would end the sampler's support.
    let (device, variant) = (Device::new(), Variant::default());
    let cell = Cell::new(&device, &variant);
    for level in [1.0e-36_f32, 1.0e-30, 1.0, 1.0e30, 1.0e36] {
        cell.fill(&device, &[level; 256]);
        for entry in cell.entries() {
            let numbers = [entry.guide_scale, entry.uniform_density, entry.acceptance_scale, entry.uniform_share];
            assert!(numbers.iter().all(|x| x.is_finite() && *x > 0.0), "{level}: {entry:?}");
        }
    }
}
