//! Twin of `glsl/include/bsdf/phong.glsl`.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};

/// Lobe about the mirror direction, over a diffuse one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phong {
    /// Exponent of the lobe's cosine.
    pub exponent: f64,
    /// Albedo of the diffuse lobe.
    pub diffuse_reflectance: DVec3,
    /// Factor of the lobe.
    pub specular_reflectance: DVec3,
}

impl Phong {
    /// Probability of the lobe about the mirror direction.
    pub fn specular_probability(&self) -> f64 {
        let [specular, diffuse] = [self.specular_reflectance, self.diffuse_reflectance].map(DVec3::element_sum);
        specular / (specular + diffuse)
    }

    fn power(&self, wo: DVec3, wi: DVec3) -> f64 {
        let mirrored = dvec3(-wo.x, -wo.y, wo.z).normalize();
        let cosine = mirrored.dot(wi.normalize());
        if cosine > 0.0 { cosine.powf(self.exponent) } else { 0.0 }
    }
}

/// Value f cos (Lafortune and Willems 1994, equation 5).
pub fn eval_bsdf_phong(b: &Phong, wo: DVec3, wi: DVec3) -> DVec3 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return DVec3::ZERO;
    }
    let lobe = (b.exponent + 2.0) / TAU * b.power(wo, wi);
    (b.specular_reflectance * lobe + b.diffuse_reflectance / PI) * wi.z
}

/// Density of `wi`, given its density under the sampler of the diffuse lobe.
pub fn pdf_bsdf_phong(b: &Phong, wo: DVec3, wi: DVec3, diffuse_density: f64) -> f64 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    let probability = b.specular_probability();
    probability * (b.exponent + 1.0) / TAU * b.power(wo, wi) + (1.0 - probability) * diffuse_density
}
