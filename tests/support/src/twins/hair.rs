//! Twin of `glsl/include/bsdf/hair.glsl`.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use lodestar::math::fresnel::fresnel_dielectric;

/// Least roughness of the kernels.
const LEAST_ROUGHNESS: f64 = 0.01;

/// Fiber of hair, which runs along the local y-axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hair {
    /// Absorption per radius.
    pub sigma_a: DVec3,
    /// Roughness along the fiber.
    pub longitudinal_roughness: f64,
    /// Roughness around the fiber.
    pub azimuthal_roughness: f64,
    /// Relative index of refraction.
    pub eta: f64,
    /// Angle by which scales rise, radians.
    pub tilt: f64,
}

impl Hair {
    /// Longitudinal variances of the lobes (Chiang et al. 2016, equation 7, and Marschner et al. 2003 for the ratios).
    fn variances(&self) -> [f64; 4] {
        let b = self.longitudinal_roughness.clamp(LEAST_ROUGHNESS, 1.0);
        let v = (0.726 * b + 0.812 * b.powi(2) + 3.7 * b.powi(20)).powi(2);
        [v, 0.25 * v, 4.0 * v, 4.0 * v]
    }

    /// Scale of the logistic distribution (Chiang et al. 2016, equation 8).
    fn scale(&self) -> f64 {
        let b = self.azimuthal_roughness.clamp(LEAST_ROUGHNESS, 1.0);
        (PI / 8.0).sqrt() * (0.265 * b + 1.194 * b.powi(2) + 5.372 * b.powi(22))
    }

    /// Shares of the light that the lobes have, for light to the eye at `wo`: a sum to 1 without absorption.
    fn shares(&self, wo: DVec3) -> [DVec3; 4] {
        let cos_t = (1.0 - (wo.y / self.eta).powi(2)).max(1e-12).sqrt();
        let sin_gamma_t = self.sin_gamma_t(wo);
        let length = 2.0 * (1.0 - sin_gamma_t * sin_gamma_t).sqrt() / cos_t;
        let transmittance = (-length * self.sigma_a).exp();
        let f = fresnel_dielectric(wo.z.abs(), self.eta).reflectance;
        let first = (1.0 - f).powi(2) * transmittance;
        let second = first * transmittance * f;
        let rest = (DVec3::ONE - f * transmittance).max(DVec3::splat(1e-12));
        [DVec3::splat(f), first, second, second * f * transmittance / rest]
    }

    /// Sine of the angle of the refracted ray in the plane across the fiber.
    fn sin_gamma_t(&self, wo: DVec3) -> f64 {
        (-wo.x / (self.eta.powi(2) - wo.y.powi(2)).max(1e-12).sqrt()).clamp(-1.0, 1.0)
    }

    /// Density of each lobe at `wi`, per steradian.
    fn densities(&self, wo: DVec3, wi: DVec3) -> [f64; 4] {
        let theta_o = wo.y.clamp(-1.0, 1.0).asin();
        let theta_i = wi.y.clamp(-1.0, 1.0).asin();
        let phi = |w: DVec3| if w.x == 0.0 && w.z == 0.0 { 0.0 } else { (-w.x).atan2(w.z) };
        let gamma_t = self.sin_gamma_t(wo).asin();
        let turns = [-2.0, 1.0, 4.0, 0.0];
        let variances = self.variances();
        [0, 1, 2, 3].map(|p| {
            let along = longitudinal(theta_i, theta_o + turns[p] * self.tilt, variances[p]);
            let center = 2.0 * p as f64 * gamma_t - phi(wo) + p as f64 * PI;
            along * if p == 3 { 1.0 / TAU } else { trimmed_logistic(phi(wi) - center, self.scale()) }
        })
    }
}

/// exp(-x) I0(x): the power series, or the asymptotic one.
fn scaled_bessel(x: f64) -> f64 {
    if x < 30.0 {
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..200 {
            term *= (0.5 * x / f64::from(k)).powi(2);
            sum += term;
        }
        return sum * (-x).exp();
    }
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..12 {
        term *= f64::from(2 * k - 1).powi(2) / (f64::from(k) * 8.0 * x);
        sum += term;
    }
    sum / (TAU * x).sqrt()
}

/// Longitudinal scattering (d'Eon et al. 2011, equation 7), without the factor that overflows.
fn longitudinal(theta_i: f64, theta_o: f64, v: f64) -> f64 {
    let (sin_i, cos_i) = theta_i.sin_cos();
    let (sin_o, cos_o) = (theta_o.sin(), theta_o.cos().abs());
    let exponent = (cos_i * cos_o - sin_i * sin_o - 1.0) / v;
    exponent.exp() * scaled_bessel(cos_i * cos_o / v) / (v * (1.0 - (-2.0 / v).exp()))
}

/// Logistic distribution on one turn.
fn trimmed_logistic(angle: f64, scale: f64) -> f64 {
    let x = angle - TAU * (angle / TAU).round();
    let cumulative = |x: f64| 1.0 / (1.0 + (-x / scale).exp());
    let e = (-x.abs() / scale).exp();
    e / (scale * (1.0 + e).powi(2)) / (cumulative(PI) - cumulative(-PI))
}

/// Value f cos.
pub fn eval_bsdf_hair(b: &Hair, wo: DVec3, wi: DVec3) -> DVec3 {
    b.shares(wo).into_iter().zip(b.densities(wo, wi)).map(|(share, density)| share * density).sum()
}

/// Density of `wi`. Lobes are drawn by the mean of their colors.
pub fn pdf_bsdf_hair(b: &Hair, wo: DVec3, wi: DVec3) -> f64 {
    let means = b.shares(wo).map(|share| share.element_sum() / 3.0);
    let sum: f64 = means.iter().zip(b.densities(wo, wi)).map(|(mean, density)| mean * density).sum();
    sum / means.iter().sum::<f64>()
}
