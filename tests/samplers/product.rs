//! Product sampler of `glsl/include/guide/samplers/product.glsl` with two or three levels below the first: 32^2 and
//! 64^2 directions.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use lodestar::encode::cosine_integrals::cosine_integrals;
use lodestar::generated::kernels::{Variant, test};
use lodestar::math::direction_map::{bin_center, representative_normal};
use lodestar::settings::{DirectionMap, Mix, Sampler};
use support::device::{Cell, Device, GROUP};
use support::guide_cases::{Density, Drawn, NORMALS, PushedNormal, variant};
use support::statistics::{Numbers, chi_square, mean_and_error, sidak, within_four_sigma};
use support::tier;
use support::twins::direction_map::{direction_bin, normal_bin, sphere_to_map};
use support::twins::normalization_entry::Rules;
use support::twins::product::{COSINE_SHARE, Product};

/// Probability that any of the chi-square tests fails by chance.
const SIGNIFICANCE: f64 = 0.01;
const SAMPLES: usize = 1 << 19;
/// Points along each side at which densities are evaluated.
const FINE: u32 = 512;
const RULES: Rules =
    Rules { sampler: Sampler::Product, mix: Mix::Density, epsilon: None, max_tries: 1, min_uniform_share: 0.0625 };

/// Twin's densities for a cell and a normal.
struct Case {
    map: DirectionMap,
    directions: u32,
    n: DVec3,
    /// Density of the descent in every bin.
    densities: Vec<f64>,
    cosine_share: f64,
}

impl Case {
    fn new(map: DirectionMap, directions: u32, n: DVec3, table: &[f32]) -> Self {
        let n = n.normalize().as_vec3().as_dvec3();
        let normals = (NORMALS * NORMALS) as usize;
        let integrals = cosine_integrals(map, directions, NORMALS);
        let of_normal = integrals.iter().skip(normal_bin(n, NORMALS) as usize).step_by(normals);
        let integrals: Vec<_> = of_normal.map(|cosine| f64::from(cosine.integral)).collect();
        let product = Product { radiance: table, integrals: &integrals };
        let densities = (0..table.len()).map(|bin| product.density(bin)).collect();
        Self { map, directions, n, densities, cosine_share: COSINE_SHARE }
    }

    fn pdf(&self, w: DVec3) -> f64 {
        let bin = direction_bin(self.map, w, self.directions) as usize;
        (1.0 - self.cosine_share) * self.densities[bin] + self.cosine_share * w.dot(self.n).max(0.0) / PI
    }

    /// Distance to the nearest border between bins, in bins.
    fn border_distance(&self, w: DVec3) -> f64 {
        let cells = (0.5 * sphere_to_map(self.map, w) + 0.5) * f64::from(self.directions);
        (cells - cells.round()).abs().min_element()
    }
}

/// Product sampler on the device.
struct Descent {
    device: Device,
    cell: Cell,
    variant: Variant,
}

impl Descent {
    fn new(map: DirectionMap, directions: u32) -> Self {
        let device = Device::new();
        let variant = Variant { direction_resolution: directions, normal_resolution: NORMALS, ..variant(&RULES, map) };
        Self { cell: Cell::new(&device, &variant), device, variant }
    }

    fn run<T: bytemuck::Pod>(
        &self,
        (source, output): (&lodestar::gpu::KernelSource, &str),
        n: DVec3,
        last: u32,
        count: usize,
    ) -> Vec<T> {
        let push = PushedNormal { normal: n.as_vec3().into(), seed_or_resolution: last };
        let out = self.device.storage("out", count * size_of::<T>());
        let (kernel, named) = (self.device.kernel(source, &self.variant), self.cell.named((output, &out)));
        self.device.dispatch_named(&kernel, &named, bytemuck::bytes_of(&push), count as u32 / GROUP);
        out.read(0, count).expect("read")
    }

    fn draw(&self, n: DVec3, seed: u32) -> Vec<Drawn> {
        self.run((&test::GUIDED_DIRECTION, "DrawnSamples"), n, seed, SAMPLES)
    }

    fn densities(&self, n: DVec3) -> Vec<Density> {
        self.run((&test::GUIDED_DENSITY, "Densities"), n, FINE, (FINE * FINE) as usize)
    }
}

fn tables(map: DirectionMap, directions: u32) -> Vec<(&'static str, Vec<f32>)> {
    let bins = directions * directions;
    let mut numbers = Numbers::new(directions);
    let noisy = (0..bins).map(|_| 10_f64.powf(numbers.between(-3.0, 3.0)) as f32).collect();
    let axis = DVec3::new(0.5, 0.3, 0.4).normalize();
    let lobe = |bin| if bin_center(map, bin, directions).dot(axis) > 0.99 { 200.0 } else { 0.1 };
    vec![("flat", vec![1.0; bins as usize]), ("noisy", noisy), ("lobe", (0..bins).map(lobe).collect())]
}

fn normals() -> [DVec3; 3] {
    [representative_normal(100, NORMALS), DVec3::new(0.3, -0.2, 0.9), DVec3::new(-0.6, 0.1, -0.7)]
}

/// Maps and resolutions that no other test has.
const SIZES: [(DirectionMap, u32); 3] =
    [(DirectionMap::EqualArea, 32), (DirectionMap::EqualArea, 64), (DirectionMap::Cylindrical, 64)];

fn fit(case: &Case, drawn: &[Drawn]) -> f64 {
    let mut counts = vec![0; case.densities.len()];
    let mut by_cosine = vec![0.0; case.densities.len()];
    // The cosine's share of each bin is a sum over points of the whole sphere.
    let fine = 4 * case.directions;
    let weight = 4.0 * PI / f64::from(fine * fine);
    for point in 0..fine * fine {
        let w = bin_center(case.map, point, fine);
        by_cosine[direction_bin(case.map, w, case.directions) as usize] += weight * w.dot(case.n).max(0.0) / PI;
    }
    drawn.iter().for_each(|d| counts[direction_bin(case.map, d.direction(), case.directions) as usize] += 1);
    let solid_angle = 4.0 * PI / case.densities.len() as f64;
    let expected = case.densities.iter().zip(&by_cosine).map(|(density, cosine)| {
        drawn.len() as f64 * ((1.0 - case.cosine_share) * density * solid_angle + case.cosine_share * cosine)
    });
    chi_square(&counts, &expected.collect::<Vec<_>>())
}

/// Samples follow their density at every resolution. The quick tier has one normal and one resolution.
#[test]
fn samples_follow_their_density_at_every_resolution() {
    let level = sidak(SIGNIFICANCE, SIZES.len() * normals().len() * 3);
    for &(map, directions) in tier::some_of(&SIZES, 1) {
        let descent = Descent::new(map, directions);
        let tables = tables(map, directions);
        for (name, table) in &tables {
            descent.cell.fill(&descent.device, table);
            for (seed, &n) in (0..).zip(tier::some_of(&normals(), 1)) {
                let title = format!("{map:?} {directions}, {name}, normal {seed}");
                let case = Case::new(map, directions, n, table);
                let drawn = descent.draw(case.n, seed);
                let p = fit(&case, &drawn);
                assert!(p > level, "{title}: chi-square {p}");
                let other = if *name == "noisy" { 0 } else { 1 };
                let p = fit(&Case::new(map, directions, n, &tables[other].1), &drawn);
                assert!(p < 1.0e-9, "{title}: another table {p}");
                check_estimate(&case, &drawn, &title);
                check_densities(&case, &descent.densities(case.n), &title);
            }
        }
    }
}

/// Samples follow the share of the cosine that their cell has learned.
#[test]
fn samples_follow_the_share_that_their_cell_has_learned() {
    let (map, directions) = (DirectionMap::EqualArea, 16);
    let mut descent = Descent::new(map, directions);
    descent.variant.learns_share = true;
    let shares = [0.1_f32, 0.5, 0.85];
    let level = sidak(SIGNIFICANCE, shares.len() * normals().len());
    let (_, table) = tables(map, directions).swap_remove(1);
    descent.cell.fill(&descent.device, &table);
    for share in shares {
        descent.cell.set_shares([share, 0.3]);
        for (seed, n) in (40..).zip(normals()) {
            let title = format!("share {share}, normal {seed}");
            let case = Case { cosine_share: share.into(), ..Case::new(map, directions, n, &table) };
            let drawn = descent.draw(case.n, seed);
            let p = fit(&case, &drawn);
            assert!(p > level, "{title}: chi-square {p}");
            let p = fit(&Case { cosine_share: 0.3, ..Case::new(map, directions, n, &table) }, &drawn);
            assert!(p < 1.0e-9, "{title}: the other share {p}");
            check_estimate(&case, &drawn, &title);
            check_densities(&case, &descent.densities(case.n), &title);
        }
    }
}

/// Fails unless each sample has the density of its direction, and the samples estimate the projected solid angle.
fn check_estimate(case: &Case, drawn: &[Drawn], title: &str) {
    let mut at_borders = 0;
    for d in drawn {
        let (w, twin) = (d.direction(), case.pdf(d.direction()));
        let known = case.border_distance(w) > 1.0e-4;
        at_borders += u32::from(!known);
        assert!(!known || (f64::from(d.pdf) / twin - 1.0).abs() < 1.0e-4, "{title}: {d:?}, not {twin}");
        assert!(!known || (d.pdf_of_wi / d.pdf - 1.0).abs() < 1.0e-4, "{title}: {d:?}");
    }
    assert!(f64::from(at_borders) < 1.0e-3 * drawn.len() as f64, "{title}: {at_borders} at borders");
    let weight = |d: &Drawn| d.direction().dot(case.n).max(0.0) / f64::from(d.pdf);
    let projected = mean_and_error(drawn.iter().map(weight));
    assert!(within_four_sigma(projected, PI), "{title}: {projected:?}");
}

fn check_densities(case: &Case, densities: &[Density], title: &str) {
    let mean = densities.iter().map(|d| f64::from(d.pdf)).sum::<f64>() / densities.len() as f64;
    assert!((4.0 * PI * mean - 1.0).abs() < 1.0e-4, "{title}: the integral is {}", 4.0 * PI * mean);
    for d in densities.iter().step_by(7) {
        let w = Vec3::from(d.wi).as_dvec3();
        if case.border_distance(w) > 1.0e-4 {
            let twin = case.pdf(w);
            // The cosine about the true normal is a sum of three rounded products.
            let most = 1.0e-4 * twin + case.cosine_share * 3.0e-7 / PI;
            assert!((f64::from(d.pdf) - twin).abs() < most, "{title}: {}, not {twin} at {w}", d.pdf);
        }
    }
}
