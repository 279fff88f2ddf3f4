//! Dielectric layers of plastics: their mean transmittance and internal reflectance, which the kernels read as
//! constants.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use rayon::prelude::*;

use crate::generated::constants;
use crate::math::fresnel::fresnel_dielectric;
use crate::math::microfacet::{Microfacets, smith_g1};

/// Entries of a table over the cosine, from grazing to normal incidence.
pub const TRANSMITTANCE_ENTRIES: usize = constants::TRANSMITTANCE_ENTRIES as usize;
/// Number of integration points along the radius over the facets seen from one direction, and along the angle or slope.
const POINTS: usize = 24;
/// Number of integration points along the radius where total reflection cuts through the facets.
const POINTS_ACROSS_EDGE: usize = 256;
/// Slope, in units of the roughness, beyond which Beckmann's distribution holds less than 1e-8 of all facets.
const STEEPEST: f64 = 4.5;

/// Layer of microfacets.
#[derive(Debug, Clone, PartialEq)]
pub struct RoughLayer {
    /// Share of the light from above that is transmitted, at equidistant cosines of incidence from 0 to 1.
    pub transmittance: [f64; TRANSMITTANCE_ENTRIES],
    /// Share of diffuse light from below that is reflected back.
    pub internal_reflectance: f64,
}

impl RoughLayer {
    /// Layer of relative index `eta` (interior over exterior). Light that facets shadow counts as lost, as in Mitsuba.
    pub fn new(facets: &Microfacets, eta: f64) -> Self {
        let (radii, across_edge) = (gauss_legendre(POINTS), gauss_legendre(POINTS_ACROSS_EDGE));
        let cosine = |entry: usize| (entry as f64 / (TRANSMITTANCE_ENTRIES - 1) as f64).max(1.0e-6);
        let shares: Vec<(f64, f64)> = (0..TRANSMITTANCE_ENTRIES)
            .into_par_iter()
            .map(|entry| {
                let cosine = cosine(entry);
                let v = dvec3((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
                let above = transmittance(facets, v, &visible_normals(facets, v, &radii), eta);
                let below = reflectance(facets, v, &visible_normals(facets, v, &across_edge), 1.0 / eta);
                (above, cosine * below)
            })
            .collect();
        let internal = shares.iter().map(|share| share.1).sum::<f64>();
        Self {
            transmittance: std::array::from_fn(|entry| shares[entry].0),
            internal_reflectance: 2.0 * internal / TRANSMITTANCE_ENTRIES as f64,
        }
    }

    /// Words of the table: one for every pair of neighbors, each neighbor a 16-bit fraction, the lower half first.
    pub fn words(&self) -> Vec<u32> {
        let fraction = |value: f64| (value.clamp(0.0, 1.0) * 65535.0).round() as u32;
        self.transmittance.windows(2).map(|pair| fraction(pair[0]) | fraction(pair[1]) << 16).collect()
    }
}

/// Share of diffuse light that a smooth surface reflects: Egan and Hilgeman (1973) for `eta` < 1, d'Eon and Irving
/// (2011) otherwise. `eta` is the index beyond the surface over the index in front of it.
pub fn fresnel_diffuse_reflectance(eta: f64) -> f64 {
    if eta < 1.0 {
        return -1.4399 * eta * eta + 0.7099 * eta + 0.6681 + 0.0636 / eta;
    }
    let powers = [0.919317, -3.4793, 6.75335, -7.80989, 4.98554, -1.36881];
    powers.iter().rev().fold(0.0, |sum, coefficient| sum / eta + coefficient)
}

type WeightedNormals = Vec<(DVec3, f64)>;

fn transmittance(facets: &Microfacets, v: DVec3, normals: &WeightedNormals, eta: f64) -> f64 {
    let through = |&(m, weight): &(DVec3, f64)| {
        let cosine = v.dot(m);
        let boundary = fresnel_dielectric(cosine, eta);
        let refracted = m * (cosine / boundary.eta - boundary.cos_t) - v / boundary.eta;
        let share = weight * (1.0 - boundary.reflectance);
        if refracted.z < 0.0 { share * smith_g1(facets, refracted) } else { 0.0 }
    };
    normals.iter().map(through).sum()
}

fn reflectance(facets: &Microfacets, v: DVec3, normals: &WeightedNormals, eta: f64) -> f64 {
    let back = |&(m, weight): &(DVec3, f64)| {
        let cosine = v.dot(m);
        let reflected = 2.0 * cosine * m - v;
        let share = weight * fresnel_dielectric(cosine, eta).reflectance;
        if reflected.z > 0.0 { share * smith_g1(facets, reflected) } else { 0.0 }
    };
    normals.iter().map(back).sum()
}

/// Normals of the facets seen from `v`, whose y is 0, with weights that sum to one.
fn visible_normals(facets: &Microfacets, v: DVec3, radii: &[(f64, f64)]) -> WeightedNormals {
    let [alpha, _] = facets.alpha;
    let stretched = dvec3(alpha * v.x, 0.0, v.z).normalize();
    let points = if facets.is_ggx { ggx_normals(stretched, radii) } else { beckmann_normals(stretched, radii) };
    let total: f64 = points.iter().map(|point| point.1).sum();
    let unstretched = |m: DVec3| dvec3(alpha * m.x, alpha * m.y, m.z.max(1.0e-12)).normalize();
    points.into_iter().map(|(m, weight)| (unstretched(m), weight / total)).collect()
}

/// Normals of GGX, uniform over a spherical cap as in `sample_visible_ggx`.
fn ggx_normals(v: DVec3, radii: &[(f64, f64)]) -> WeightedNormals {
    let k = 1.0 + v.z;
    let point = |r2: f64, angle: f64| {
        let radius = (r2 * k * (2.0 - r2 * k)).max(0.0).sqrt();
        dvec3(radius * angle.cos() + v.x, radius * angle.sin(), k * (1.0 - r2))
    };
    let angles = (0..POINTS).map(|i| PI * (i as f64 + 0.5) / POINTS as f64);
    angles.flat_map(|angle| radii.iter().map(move |&(r2, weight)| (point(r2, angle), weight))).collect()
}

/// Normals of Beckmann from slopes along and across the plane of incidence. Each is weighted by its Gaussian and by its
/// cosine to the viewer.
fn beckmann_normals(v: DVec3, radii: &[(f64, f64)]) -> WeightedNormals {
    let most = (v.z / v.x.max(1.0e-12)).min(STEEPEST);
    let across = (0..POINTS).map(|i| STEEPEST * (i as f64 + 0.5) / POINTS as f64);
    let normal = |x: f64, y: f64, weight: f64| {
        let visible = (v.z - x * v.x) * (-x * x - y * y).exp();
        (dvec3(-x, y, 1.0), weight * visible)
    };
    across
        .flat_map(|y| radii.iter().map(move |&(t, weight)| normal((most + STEEPEST) * t - STEEPEST, y, weight)))
        .collect()
}

/// Points and weights of Gauss-Legendre quadrature over [0, 1].
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    (0..count)
        .map(|index| {
            let mut x = (PI * (index as f64 + 0.75) / (count as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..20 {
                let (value, derivative) = legendre(count, x);
                slope = derivative;
                x -= value / derivative;
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Legendre polynomial of the given degree, and its derivative.
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut value) = (1.0, x);
    for n in 2..=degree {
        let n = n as f64;
        (previous, value) = (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * previous) / n);
    }
    (value, degree as f64 * (x * value - previous) / (x * x - 1.0))
}

#[test]
fn quadrature_is_exact_for_polynomials() {
    let integral = |power: i32| gauss_legendre(POINTS).iter().map(|&(x, w)| w * x.powi(power)).sum::<f64>();
    for power in 0..2 * POINTS as i32 {
        assert!((integral(power) * f64::from(power + 1) - 1.0).abs() < 1.0e-12, "x^{power}: {}", integral(power));
    }
}

#[test]
fn finer_quadratures_agree() {
    for (is_ggx, alpha) in [(true, 0.1), (true, 0.5), (false, 0.1), (false, 0.5)] {
        let facets = Microfacets::new([alpha; 2], is_ggx);
        let layer = RoughLayer::new(&facets, 1.5);
        let fine = gauss_legendre(400);
        let mut internal = 0.0;
        for (entry, ours) in layer.transmittance.iter().enumerate() {
            let cosine = (entry as f64 / 63.0).max(1.0e-6);
            let v = dvec3((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let normals = visible_normals(&facets, v, &fine);
            let finer = transmittance(&facets, v, &normals, 1.5);
            assert!((ours - finer).abs() < 2.0e-4, "{is_ggx}, {alpha}, entry {entry}: {ours}, not {finer}");
            internal += cosine * reflectance(&facets, v, &normals, 1.0 / 1.5) / 32.0;
        }
        let ours = layer.internal_reflectance;
        assert!((ours - internal).abs() < 5.0e-4, "{is_ggx}, {alpha}: {ours}, not {internal}");
        // Another index gives another share from inside.
        let denser = RoughLayer::new(&facets, 1.51).internal_reflectance;
        assert!((denser - internal).abs() > 1.0e-3, "{is_ggx}, {alpha}: the index hardly matters");
    }
}
