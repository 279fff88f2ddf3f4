//! Twin of `glsl/include/bsdf/rough_diffuse.glsl`.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

/// Surface of V-shaped grooves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoughDiffuse {
    /// Albedo of the facets.
    pub reflectance: DVec3,
    /// Roughness: sqrt(2) times the standard deviation of the facets' angles.
    pub alpha: f64,
    /// Whether Oren and Nayar's qualitative model replaces the full one.
    pub fast_approximation: bool,
    /// Whether the energy-preserving model replaces both; the roughness then lies in [0, 1].
    pub energy_preserving: bool,
}

/// Value f cos (Oren and Nayar 1994, equations 29 to 31), by the paper's angles.
pub fn eval_bsdf_rough_diffuse(b: &RoughDiffuse, wo: DVec3, wi: DVec3) -> DVec3 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return DVec3::ZERO;
    }
    if b.energy_preserving {
        return energy_preserving(b.reflectance, b.alpha, wo, wi);
    }
    let angle = |w: DVec3| w.truncate().length().atan2(w.z);
    let alpha = angle(wo).max(angle(wi));
    let beta = angle(wo).min(angle(wi));
    let azimuths = wo.truncate().normalize_or_zero().dot(wi.truncate().normalize_or_zero());
    let reflected = if b.fast_approximation {
        b.reflectance * fast(b.alpha, azimuths, alpha, beta)
    } else {
        full(b, azimuths, alpha, beta)
    };
    reflected * wi.z / PI
}

/// Albedo of Fujii's model for light that makes an angle with the normal, in the form that Portsmouth, Kutz and Hill (2024) give.
fn fujii_albedo(a: f64, roughness: f64, cosine: f64) -> f64 {
    let (angle, sine) = (cosine.acos(), cosine.acos().sin());
    let g = sine * (angle - sine * cosine) + 2.0 / 3.0 * (sine / cosine * (1.0 - sine.powi(3)) - sine);
    a * PI + roughness * a * g
}

/// The model of Portsmouth, Kutz and Hill (2024). The term of several reflections has the reflectance once more, as in Cycles.
pub fn energy_preserving(reflectance: DVec3, roughness: f64, wo: DVec3, wi: DVec3) -> DVec3 {
    if roughness == 0.0 {
        return reflectance * (wi.z / PI);
    }
    let a = 1.0 / (PI + (FRAC_PI_2 - 2.0 / 3.0) * roughness);
    let s = wo.dot(wi) - wo.z * wi.z;
    let once = a * (1.0 + roughness * if s > 0.0 { s / wo.z.max(wi.z) } else { s });
    let mean = a * PI + roughness * a * (2.0 * PI - 5.6) / 3.0;
    let losses = [wo.z, wi.z].map(|cosine| 1.0 - fujii_albedo(a, roughness, cosine));
    let color = reflectance.powf(3.0) * mean / (DVec3::ONE - reflectance * (1.0 - mean));
    (reflectance * once + color * (losses[0] * losses[1] / ((1.0 - mean) * PI))) * wi.z
}

fn variance(alpha: f64) -> f64 {
    0.5 * alpha * alpha
}

fn fast(roughness: f64, cos_phi: f64, alpha: f64, beta: f64) -> f64 {
    let v = variance(roughness);
    let (a, b) = (1.0 - 0.5 * v / (v + 0.33), 0.45 * v / (v + 0.09));
    a + b * cos_phi.max(0.0) * alpha.sin() * beta.tan()
}

fn full(b: &RoughDiffuse, cos_phi: f64, alpha: f64, beta: f64) -> DVec3 {
    let v = variance(b.alpha);
    let c1 = 1.0 - 0.5 * v / (v + 0.33);
    let deviation = if cos_phi >= 0.0 { 0.0 } else { (beta / FRAC_PI_2).powi(3) };
    let c2 = 0.45 * v / (v + 0.09) * (alpha.sin() - deviation);
    let c3 = 0.125 * v / (v + 0.09) * (4.0 * alpha * beta / (PI * PI)).powi(2);
    let once = c1 + cos_phi * c2 * beta.tan() + (1.0 - cos_phi.abs()) * c3 * (0.5 * (alpha + beta)).tan();
    let twice = 0.17 * v / (v + 0.13) * (1.0 - cos_phi * (beta / FRAC_PI_2).powi(2));
    b.reflectance * (once + b.reflectance * twice)
}
