//! Twin of `glsl/include/bsdf/plastic.glsl` and `bsdf/rough_plastic.glsl`.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use lodestar::math::fresnel::fresnel_dielectric;
use lodestar::math::microfacet::{Microfacets, smith_g1};

use super::conductor::pdf_reflection;
use super::delta::DeltaLobe;
use super::film::{Film, filmed};
use super::microfacet::microfacet_density;
use super::rough_diffuse::energy_preserving;

/// Dielectric layer over a diffuse base.
#[derive(Debug, Clone, PartialEq)]
pub struct Plastic {
    /// Index of refraction, interior over exterior.
    pub eta: f64,
    /// Albedo of the base.
    pub diffuse_reflectance: DVec3,
    /// Factor of the light that the layer reflects.
    pub specular_reflectance: DVec3,
    /// Whether internal scattering shifts the color.
    pub nonlinear: bool,
    /// Share of diffuse light that the layer sends back to the base.
    pub internal_reflectance: f64,
    /// Share of the mean specular albedo in the sum of both mean albedos.
    pub specular_sampling: f64,
    /// Surface of the layer, if it is rough.
    pub rough: Option<RoughSurface>,
    /// Share of the base that is left, where the layer takes no light from it.
    pub base_weight: Option<f64>,
    /// Roughness of a weighted base.
    pub base_roughness: f64,
    /// Thin film over the surface.
    pub film: Option<Film>,
}

/// Surface of a rough layer.
#[derive(Debug, Clone, PartialEq)]
pub struct RoughSurface {
    /// Facets of the surface.
    pub facets: Microfacets,
    /// Share of light from above that passes, at evenly spaced cosines from 0 to 1.
    pub transmittance: Vec<f64>,
}

impl Plastic {
    fn transmittance(&self, cos_theta: f64) -> f64 {
        let Some(rough) = &self.rough else {
            let plain = fresnel_dielectric(cos_theta, self.eta).reflectance;
            return 1.0 - filmed(self.film, cos_theta, self.eta).map_or(plain, |(_, mean)| mean);
        };
        let last = rough.transmittance.len() - 1;
        let position = cos_theta * last as f64;
        let entry = (position as usize).min(last - 1);
        let between = position - entry as f64;
        rough.transmittance[entry] * (1.0 - between) + rough.transmittance[entry + 1] * between
    }

    /// Probability that a sample takes the specular lobe.
    pub fn specular_probability(&self, wo: DVec3) -> f64 {
        let transmittance = self.transmittance(wo.z);
        let (specular, diffuse) = match self.base_weight {
            Some(weight) => (
                (1.0 - transmittance) * self.specular_reflectance.max_element(),
                weight * self.diffuse_reflectance.max_element(),
            ),
            None => ((1.0 - transmittance) * self.specular_sampling, transmittance * (1.0 - self.specular_sampling)),
        };
        if specular + diffuse > 0.0 { specular / (specular + diffuse) } else { 0.0 }
    }
}

/// Lobe of a smooth layer's reflection.
pub fn plastic_lobes(b: &Plastic, wo: DVec3) -> Vec<DeltaLobe> {
    if wo.z <= 0.0 || b.rough.is_some() {
        return vec![];
    }
    let plain = DVec3::splat(1.0 - b.transmittance(wo.z));
    let value = b.specular_reflectance * filmed(b.film, wo.z, b.eta).map_or(plain, |(reflectance, _)| reflectance);
    vec![DeltaLobe { wi: dvec3(-wo.x, -wo.y, wo.z), probability: b.specular_probability(wo), value, eta: 1.0 }]
}

/// Value f cos, without the smooth layer's reflection.
pub fn eval_bsdf_plastic(b: &Plastic, wo: DVec3, wi: DVec3) -> DVec3 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return DVec3::ZERO;
    }
    let of_layer = b.rough.as_ref().map_or(DVec3::ZERO, |rough| specular(b, &rough.facets, wo, wi));
    if let Some(weight) = b.base_weight {
        let left = filmed(b.film, wo.z, b.eta).map_or(1.0, |(reflectance, _)| 1.0 - reflectance.max_element());
        return energy_preserving(b.diffuse_reflectance, b.base_roughness, wo, wi) * weight * left + of_layer;
    }
    let returned = if b.nonlinear { b.diffuse_reflectance } else { DVec3::ONE } * b.internal_reflectance;
    let base = b.diffuse_reflectance / (DVec3::ONE - returned);
    let passing = b.transmittance(wo.z) * b.transmittance(wi.z) / b.eta.powi(2);
    base * (passing * wi.z / PI) + of_layer
}

fn specular(b: &Plastic, facets: &Microfacets, wo: DVec3, wi: DVec3) -> DVec3 {
    let m = (wo + wi).normalize();
    let reflectance = fresnel_dielectric(wo.dot(m), b.eta).reflectance;
    let masking = smith_g1(facets, wo) * smith_g1(facets, wi);
    b.specular_reflectance * (reflectance * microfacet_density(facets, m) * masking / (4.0 * wo.z))
}

/// Density of `wi`, given its density under the sampler of the diffuse lobe.
pub fn pdf_bsdf_plastic(b: &Plastic, wo: DVec3, wi: DVec3, diffuse_density: f64) -> f64 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    let probability = b.specular_probability(wo);
    let specular = b.rough.as_ref().map_or(0.0, |rough| pdf_reflection(&rough.facets, wo, wi));
    (1.0 - probability) * diffuse_density + probability * specular
}
