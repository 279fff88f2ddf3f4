//! Goodness of fit, and random numbers for the host.

use std::sync::OnceLock;

use glam::{DVec3, dvec3};
use lodestar::settings::DirectionMap;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::twins::cosine::SphereGrid;
use crate::twins::random::{RandomKey, RandomStream, SampleSet, next_random, random_stream};

/// Minimum expected count of a cell. Cells below it are pooled (Cochran 1954).
const LEAST_EXPECTED: f64 = 5.0;

/// Probability of a fit at least as bad, by Pearson's chi-square test without fitted parameters. The totals are not
/// made to agree, so a density that does not integrate to one fits badly.
pub fn chi_square(observed: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len());
    let (small, large): (Vec<_>, Vec<_>) =
        expected.iter().zip(observed).map(|(&e, &o)| (e, o as f64)).partition(|cell| cell.0 < LEAST_EXPECTED);
    let pool = small.iter().fold((0.0, 0.0), |sum, cell| (sum.0 + cell.0, sum.1 + cell.1));
    // The pool stays even if nothing is expected in it, so that samples there are noticed.
    let pool = (!small.is_empty()).then_some(pool);
    let terms: Vec<f64> = large.into_iter().chain(pool).map(|(e, o)| (o - e).powi(2) / e.max(LEAST_EXPECTED)).collect();
    assert!(terms.len() >= 2, "too few samples for a chi-square");
    ChiSquared::new(terms.len() as f64 - 1.0).expect("positive").sf(terms.iter().sum())
}

/// Level of each of `count` tests such that all of them pass with probability `1 - all` (Sidak 1967).
pub fn sidak(all: f64, count: usize) -> f64 {
    -((-all).ln_1p() / count as f64).exp_m1()
}

/// P-value of numbers in [0, 1) against the uniform distribution, over `bins` cells.
pub fn uniformity(values: impl IntoIterator<Item = f64>, bins: usize) -> f64 {
    let mut counts = vec![0; bins];
    for value in values {
        counts[((value * bins as f64) as usize).min(bins - 1)] += 1;
    }
    chi_square(&counts, &even(&counts))
}

/// P-value of pairs in [0, 1)^2 against the uniform distribution, over `bins^2` cells.
pub fn pair_uniformity(pairs: impl IntoIterator<Item = (f64, f64)>, bins: usize) -> f64 {
    let mut counts = vec![0; bins * bins];
    let cell = |x: f64| ((x * bins as f64) as usize).min(bins - 1);
    for (x, y) in pairs {
        counts[cell(y) * bins + cell(x)] += 1;
    }
    chi_square(&counts, &even(&counts))
}

fn even(counts: &[u64]) -> Vec<f64> {
    vec![counts.iter().sum::<u64>() as f64 / counts.len() as f64; counts.len()]
}

/// Mean of values and its standard error.
pub fn mean_and_error(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// Whether a mean lies within four standard errors (significance 6e-5) of `expected`, or within rounding.
pub fn within_four_sigma((mean, error): (f64, f64), expected: f64) -> bool {
    (mean - expected).abs() <= 4.0 * error + 1e-6 * expected.abs()
}

/// Random numbers of a test.
pub struct Numbers(RandomStream);

impl Numbers {
    pub fn new(seed: u32) -> Self {
        Self(random_stream(RandomKey { pixel: 0, sample_index: 0, set: SampleSet::Alone, seed }, 0, 7))
    }

    pub fn unit(&mut self) -> f64 {
        next_random(&mut self.0)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn unit_vector(&mut self) -> DVec3 {
        let (z, phi) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        dvec3(r * phi.cos(), r * phi.sin(), z)
    }
}

/// A million points of a map that cover the sphere. The renderer integrates over none of them.
pub fn sphere(map: DirectionMap) -> &'static SphereGrid {
    static SPHERES: [OnceLock<SphereGrid>; 2] = [OnceLock::new(), OnceLock::new()];
    SPHERES[map as usize].get_or_init(|| SphereGrid::new(map, 1056))
}
