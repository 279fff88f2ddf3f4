//! Twin of `glsl/include/bsdf/conductor.glsl` and `bsdf/rough_conductor.glsl`.

use glam::{DVec3, dvec3};
use lodestar::math::microfacet::{Microfacets, smith_g1};

use super::delta::DeltaLobe;
use super::film::Film;
use super::fresnel::fresnel_conductor;
use super::microfacet::{microfacet_density, pdf_visible_normal};

/// Metal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conductor {
    /// Factor of the reflected light.
    pub specular_reflectance: DVec3,
    /// Index of refraction, real part.
    pub eta: DVec3,
    /// Index of refraction, imaginary part.
    pub k: DVec3,
    /// Thin film over the surface.
    pub film: Option<Film>,
}

impl Conductor {
    fn reflectance(&self, cosine: f64) -> DVec3 {
        match self.film {
            Some(film) => film.reflectance(cosine, self.eta, self.k),
            None => fresnel_conductor(cosine, self.eta, self.k),
        }
    }
}

/// Lobe of a smooth metal, if it is seen from above.
pub fn conductor_lobes(b: &Conductor, wo: DVec3) -> Vec<DeltaLobe> {
    if wo.z <= 0.0 {
        return vec![];
    }
    let value = b.specular_reflectance * b.reflectance(wo.z);
    vec![DeltaLobe { wi: dvec3(-wo.x, -wo.y, wo.z), probability: 1.0, value, eta: 1.0 }]
}

/// Value f cos of a rough metal (Walter et al. 2007, equation 20).
pub fn eval_bsdf_rough_conductor(b: &Conductor, facets: &Microfacets, wo: DVec3, wi: DVec3) -> DVec3 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return DVec3::ZERO;
    }
    let m = (wo + wi).normalize();
    let light = microfacet_density(facets, m) * smith_g1(facets, wo) * smith_g1(facets, wi) / (4.0 * wo.z);
    b.specular_reflectance * b.reflectance(wo.dot(m)) * light
}

/// Density of `wi` for samples that reflect at visible facets.
pub fn pdf_reflection(facets: &Microfacets, wo: DVec3, wi: DVec3) -> f64 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    let m = (wo + wi).normalize();
    pdf_visible_normal(facets, wo, m) / (4.0 * wo.dot(m))
}
