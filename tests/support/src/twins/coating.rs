//! Twin of `glsl/include/bsdf/coating.glsl`.

use glam::DVec3;
use lodestar::math::fresnel::fresnel_dielectric;

/// Smooth dielectric layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coating {
    /// Index of refraction, interior over exterior.
    pub eta: f64,
    /// Absorption times thickness.
    pub optical_thickness: DVec3,
    /// Factor of the light that the layer reflects.
    pub specular_reflectance: DVec3,
}

/// Direction inside the layer, and the layer's reflectance.
pub fn enter_coating(c: &Coating, w: DVec3) -> (DVec3, f64) {
    let interface = fresnel_dielectric(w.z.abs(), c.eta);
    let inside = (w.truncate() / c.eta).extend(interface.cos_t.copysign(w.z));
    (inside, interface.reflectance)
}

/// Probability that the layer's reflection is sampled.
pub fn coating_probability(c: &Coating, wo: DVec3) -> f64 {
    let passing = c.optical_thickness.to_array().map(|x| (-2.0 * x).exp()).iter().sum::<f64>() / 3.0;
    let weight = 1.0 / (1.0 + passing);
    let reflectance = enter_coating(c, wo).1;
    let [specular, nested] = [reflectance * weight, (1.0 - reflectance) * (1.0 - weight)];
    specular / (specular + nested)
}

/// Solid angle inside per solid angle outside, at the light's direction.
fn jacobian(c: &Coating, wi: DVec3) -> f64 {
    (wi.z / enter_coating(c, wi).0.z / (c.eta * c.eta)).abs()
}

/// Value f cos of the coated surface, given that of the surface inside.
pub fn eval_coating(c: &Coating, wo: DVec3, wi: DVec3, nested: impl Fn(DVec3, DVec3) -> DVec3) -> DVec3 {
    let [(o, reflected_o), (i, reflected_i)] = [wo, wi].map(|w| enter_coating(c, w));
    let paths = 1.0 / o.z.abs() + 1.0 / i.z.abs();
    let absorbed = (-paths * c.optical_thickness).exp();
    nested(o, i) * absorbed * ((1.0 - reflected_o) * (1.0 - reflected_i) * jacobian(c, wi))
}

/// Density of `wi`, given that of the surface inside.
pub fn pdf_coating(c: &Coating, wo: DVec3, wi: DVec3, nested: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let [o, i] = [wo, wi].map(|w| enter_coating(c, w).0);
    (1.0 - coating_probability(c, wo)) * nested(o, i) * jacobian(c, wi)
}
