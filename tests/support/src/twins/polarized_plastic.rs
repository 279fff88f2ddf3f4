//! Twin of `glsl/include/bsdf/rough_plastic.glsl` with a smooth base: Mitsuba's `pplastic` without polarization, whose base may have a
//! weight.

use std::f64::consts::PI;

use glam::DVec3;
use lodestar::math::fresnel::fresnel_dielectric;
use lodestar::math::microfacet::{Microfacets, smith_g1};

use super::conductor::pdf_reflection;
use super::film::{Film, filmed};
use super::microfacet::microfacet_density;
use super::rough_diffuse::energy_preserving;

/// Microfacets of a dielectric, and a diffuse base that light reaches as through a smooth surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarizedPlastic {
    /// Index of refraction, interior over exterior.
    pub eta: f64,
    /// Albedo of the base.
    pub diffuse_reflectance: DVec3,
    /// Factor of the light that the facets reflect.
    pub specular_reflectance: DVec3,
    /// Facets of the surface.
    pub facets: Microfacets,
    /// Share of the base that is left, where the facets take no light from it.
    pub base_weight: Option<f64>,
    /// Roughness of a weighted base.
    pub base_roughness: f64,
    /// Thin film over the surface.
    pub film: Option<Film>,
}

impl PolarizedPlastic {
    fn transmittance(&self, cosine: f64) -> f64 {
        1.0 - filmed(self.film, cosine, self.eta)
            .map_or(fresnel_dielectric(cosine, self.eta).reflectance, |(_, mean)| mean)
    }

    /// Share of the mean specular albedo in the sum of both mean albedos.
    pub fn specular_sampling(&self) -> f64 {
        let [specular, diffuse] = [self.specular_reflectance, self.diffuse_reflectance].map(DVec3::element_sum);
        specular / (specular + diffuse)
    }

    fn specular_probability(&self, wo: DVec3) -> f64 {
        let transmittance = self.transmittance(wo.z);
        if let Some(weight) = self.base_weight {
            let specular = (1.0 - transmittance) * self.specular_reflectance.max_element();
            return specular / (specular + weight * self.diffuse_reflectance.max_element());
        }
        let specular = (1.0 - transmittance) * self.specular_sampling();
        specular / (specular + transmittance * (1.0 - self.specular_sampling()))
    }
}

/// Value f cos.
pub fn eval_bsdf_polarized_plastic(b: &PolarizedPlastic, wo: DVec3, wi: DVec3) -> DVec3 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return DVec3::ZERO;
    }
    let m = (wo + wi).normalize();
    let masking = smith_g1(&b.facets, wo) * smith_g1(&b.facets, wi);
    let facets = microfacet_density(&b.facets, m) * masking / (4.0 * wo.z);
    let plain = DVec3::splat(fresnel_dielectric(wo.dot(m), b.eta).reflectance);
    let reflectance = filmed(b.film, wo.dot(m), b.eta).map_or(plain, |(reflectance, _)| reflectance);
    // The base has what the film leaves of the color that it reflects most.
    let left = filmed(b.film, wo.z, b.eta).map_or(1.0, |(reflectance, _)| 1.0 - reflectance.max_element());
    let base = match b.base_weight {
        Some(weight) => energy_preserving(b.diffuse_reflectance, b.base_roughness, wo, wi) * weight * left,
        None => b.diffuse_reflectance * (b.transmittance(wo.z) * b.transmittance(wi.z) * wi.z / PI),
    };
    b.specular_reflectance * reflectance * facets + base
}

/// Density of `wi`, given its density under the sampler of the diffuse lobe.
pub fn pdf_bsdf_polarized_plastic(b: &PolarizedPlastic, wo: DVec3, wi: DVec3, diffuse_density: f64) -> f64 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    let probability = b.specular_probability(wo);
    probability * pdf_reflection(&b.facets, wo, wi) + (1.0 - probability) * diffuse_density
}
