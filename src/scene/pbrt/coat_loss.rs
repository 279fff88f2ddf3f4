//! Light that a coat absorbs, as a darker base under a coat without loss.

use crate::math::fresnel::fresnel_dielectric;

/// Number of angles over which the light within a coat is summed.
const ANGLES: usize = 512;
/// Cosine within a coat of light that comes from outside, about the mean over all directions.
const MEAN_COSINE: f64 = 0.88;
/// Light that is lost on its ways through a coat.
pub(super) struct Loss {
    /// Share of the base's light that the coat's surface reflects back, without loss.
    reflected: f64,
    /// Share of the base's light that leaves the coat.
    leaving: f64,
    /// Share of the base's light that comes back to the base.
    returning: f64,
    /// Share of the light from outside that comes to the base.
    entering: f64,
}

impl Loss {
    /// Loss in a coat of this index of refraction, where light keeps `exp(-thickness / cosine)` on each way.
    pub fn new(eta: f64, thickness: f64) -> Self {
        let mut loss =
            Self { reflected: 0.0, leaving: 0.0, returning: 0.0, entering: (-thickness / MEAN_COSINE).exp() };
        for angle in 0..ANGLES {
            let cosine = (angle as f64 + 0.5) / ANGLES as f64;
            // Light from within meets the interface from its back.
            let reflected = fresnel_dielectric(-cosine, eta).reflectance;
            let (weight, kept) = (2.0 * cosine / ANGLES as f64, (-thickness / cosine).exp());
            loss.reflected += weight * reflected;
            loss.leaving += weight * (1.0 - reflected) * kept;
            loss.returning += weight * reflected * kept * kept;
        }
        loss
    }

    /// Albedo of the base under a coat without loss that reflects what the base of this albedo reflects under the coat.
    pub fn base(&self, albedo: f64) -> f64 {
        let out = self.entering * albedo * self.leaving / (1.0 - albedo * self.returning);
        out / ((1.0 - self.reflected) + out * self.reflected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that is followed bounce by bounce through a coat, as pbrt follows it at random.
    fn followed(albedo: f64, eta: f64, thickness: f64, base: f64, is_lossless: bool) -> f64 {
        let kept = |cosine: f64| if is_lossless { 1.0 } else { (-thickness / cosine).exp() };
        let mut light = if is_lossless { base } else { albedo * kept(MEAN_COSINE) };
        let mut sum = 0.0;
        for _ in 0..200 {
            let mut back = 0.0;
            for angle in 0..2000 {
                let cosine = (f64::from(angle) + 0.5) / 2000.0;
                let reflected = fresnel_dielectric(-cosine, eta).reflectance;
                let weight = light * 2.0 * cosine / 2000.0;
                sum += weight * (1.0 - reflected) * kept(cosine);
                back += weight * reflected * kept(cosine).powi(2);
            }
            light = back * if is_lossless { base } else { albedo };
        }
        sum
    }

    #[test]
    fn a_coat_without_loss_reflects_as_much() {
        for (albedo, eta, thickness) in [(0.1, 1.5, 0.01), (0.5, 1.5, 0.01), (0.95, 1.3, 0.1), (0.5, 1.5, 0.0)] {
            let base = Loss::new(eta, thickness).base(albedo);
            let (with_loss, without) =
                (followed(albedo, eta, thickness, base, false), followed(albedo, eta, thickness, base, true));
            assert!((with_loss - without).abs() < 2e-3 * with_loss, "{albedo}: {with_loss} is not {without}");
            assert!(base <= albedo && (thickness > 0.0 || (base - albedo).abs() < 1e-9));
        }
    }
}
