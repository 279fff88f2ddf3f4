//! Twin of `glsl/include/bsdf/dielectric.glsl`, `bsdf/thin_dielectric.glsl` and `bsdf/rough_dielectric.glsl`.

use glam::{DVec3, dvec3};
use lodestar::math::fresnel::fresnel_dielectric;
use lodestar::math::microfacet::{Microfacets, smith_g1};

use super::delta::DeltaLobe;
use super::film::{Film, filmed};
use super::microfacet::{microfacet_density, pdf_visible_normal};

/// Surface between two dielectrics, or a thin sheet of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dielectric {
    /// Index of refraction, interior over exterior.
    pub eta: f64,
    /// Factor of the reflected light.
    pub specular_reflectance: DVec3,
    /// Factor of the transmitted light.
    pub specular_transmittance: DVec3,
    /// Thin film over the surface.
    pub film: Option<Film>,
}

/// Lobes of a smooth surface.
pub fn dielectric_lobes(b: &Dielectric, wo: DVec3) -> Vec<DeltaLobe> {
    let boundary = fresnel_dielectric(wo.z, b.eta);
    let through = dvec3(-wo.x / boundary.eta, -wo.y / boundary.eta, -boundary.cos_t.copysign(wo.z));
    // Radiance grows with the square of the index.
    let compression = boundary.eta.powi(-2);
    let plain = (DVec3::splat(boundary.reflectance), boundary.reflectance);
    lobes(b, wo, filmed(b.film, wo.z, b.eta).unwrap_or(plain), through, boundary.eta, compression)
}

/// Lobes of a thin sheet.
pub fn thin_dielectric_lobes(b: &Dielectric, wo: DVec3) -> Vec<DeltaLobe> {
    let r = fresnel_dielectric(wo.z.abs(), b.eta).reflectance;
    // The second part is the sum over all orders of internal reflection, (1 - r)^2 r^(2 n + 1).
    let reflectance = if r < 1.0 { r + (1.0 - r).powi(2) * r / (1.0 - r * r) } else { 1.0 };
    lobes(b, wo, (DVec3::splat(reflectance), reflectance), -wo, 1.0, 1.0)
}

/// `reflectance` is followed by the probability of reflection.
fn lobes(
    b: &Dielectric,
    wo: DVec3,
    (reflectance, probability): (DVec3, f64),
    through: DVec3,
    eta: f64,
    compression: f64,
) -> Vec<DeltaLobe> {
    if wo.z == 0.0 {
        return vec![];
    }
    let back = dvec3(-wo.x, -wo.y, wo.z);
    let transmitted = b.specular_transmittance * (1.0 - reflectance) * compression;
    vec![
        DeltaLobe { wi: back, probability, value: b.specular_reflectance * reflectance, eta: 1.0 },
        DeltaLobe { wi: through, probability: 1.0 - probability, value: transmitted, eta },
    ]
}

/// Facets that scatter light between two directions.
struct Facet {
    /// Normal of the facets, on the upper side.
    m: DVec3,
    reflectance: DVec3,
    /// Probability that a facet reflects a sample.
    probability: f64,
    /// Index on the side of `wi` over that on the side of `wo`.
    eta: f64,
    /// Whether each direction sees the facets from its own side of the surface.
    is_visible: bool,
}

fn facet(b: &Dielectric, wo: DVec3, wi: DVec3) -> Facet {
    let eta = b.eta;
    let relative = if wo.z > 0.0 { eta } else { 1.0 / eta };
    let half = if wo.z * wi.z > 0.0 { wo + wi } else { wo + relative * wi };
    let m = half.normalize() * half.z.signum();
    let plain = fresnel_dielectric(wo.dot(m), eta).reflectance;
    let (reflectance, probability) = filmed(b.film, wo.dot(m), eta).unwrap_or((DVec3::splat(plain), plain));
    Facet { m, reflectance, probability, eta: relative, is_visible: wo.dot(m) * wo.z > 0.0 && wi.dot(m) * wi.z > 0.0 }
}

/// Solid angle of normals per solid angle of directions (Walter et al. 2007, equations 14 and 17).
fn jacobian(wo: DVec3, wi: DVec3, facet: &Facet) -> f64 {
    if wo.z * wi.z > 0.0 {
        return 1.0 / (4.0 * wi.dot(facet.m).abs());
    }
    let sum = wo.dot(facet.m) + facet.eta * wi.dot(facet.m);
    facet.eta.powi(2) * wi.dot(facet.m).abs() / sum.powi(2)
}

/// Value f |cos| (Walter et al. 2007, equations 20 and 21), scaled for radiance.
pub fn eval_bsdf_rough_dielectric(b: &Dielectric, facets: &Microfacets, wo: DVec3, wi: DVec3) -> DVec3 {
    let f = facet(b, wo, wi);
    if wo.z * wi.z == 0.0 || !f.is_visible {
        return DVec3::ZERO;
    }
    let masking = smith_g1(facets, wo) * smith_g1(facets, wi);
    let light = microfacet_density(facets, f.m) * masking * (wo.dot(f.m) / wo.z).abs() * jacobian(wo, wi, &f);
    match wo.z * wi.z > 0.0 {
        true => b.specular_reflectance * (f.reflectance * light),
        false => b.specular_transmittance * ((1.0 - f.reflectance) * light * f.eta.powi(-2)),
    }
}

/// Density of `wi`.
pub fn pdf_bsdf_rough_dielectric(b: &Dielectric, facets: &Microfacets, wo: DVec3, wi: DVec3) -> f64 {
    let f = facet(b, wo, wi);
    if wo.z * wi.z == 0.0 || !f.is_visible {
        return 0.0;
    }
    let share = if wo.z * wi.z > 0.0 { f.probability } else { 1.0 - f.probability };
    share * pdf_visible_normal(facets, wo * wo.z.signum(), f.m) * jacobian(wo, wi, &f)
}
