//! Twin of `glsl/include/bsdf/sheen.glsl`.

use std::f64::consts::PI;

use glam::{DMat2, DVec2, DVec3};
use lodestar::encode::sheen::{Lobe, entry};

/// Layer of microfibers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheen {
    /// Factor of the light that the fibers reflect.
    pub reflectance: DVec3,
    /// Roughness, from 0 to 1.
    pub roughness: f64,
}

/// Largest probability of the sheen's own lobe: `MOST_SHEEN` of the file.
const MOST_SHEEN: f64 = 0.75;

impl Sheen {
    /// Numbers of the lobe for a cosine of `wo`: the mean of the table's four entries about it.
    pub fn lobe(&self, cosine: f64) -> Lobe {
        let [row, column] = [self.roughness, cosine].map(|x| 31.0 * x.clamp(0.0, 1.0));
        let [i, j] = [row, column].map(|x| (x as usize).min(30));
        let mut sum = Lobe { stretch: 0.0, shift: 0.0, albedo: 0.0 };
        for (di, dj) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let share = |x: f64, at: usize| 1.0 - (x - at as f64).abs();
            let (weight, e) = (share(row, i + di) * share(column, j + dj), entry(i + di, j + dj));
            sum.stretch += weight * e.stretch;
            sum.shift += weight * e.shift;
            sum.albedo += weight * e.albedo;
        }
        sum
    }

    /// Share of what lies below that is left.
    pub fn kept(&self, cosine: f64) -> f64 {
        1.0 - self.lobe(cosine).albedo * self.reflectance.max_element()
    }

    /// Probability of the sheen's own lobe over a surface that sheds `below` of the light.
    pub fn probability(&self, cosine: f64, below: f64) -> f64 {
        let kept = self.kept(cosine);
        ((1.0 - kept) / (1.0 - kept + kept * below).max(1.0e-20)).min(MOST_SHEEN)
    }

    /// Value f cos of the layer with that of the surface below.
    pub fn eval(&self, wo: DVec3, wi: DVec3, nested: DVec3) -> DVec3 {
        let albedo = self.lobe(wo.z).albedo * self.reflectance;
        nested * self.kept(wo.z) + albedo * self.density(wo, wi)
    }

    /// Density of the lobe: that of the cosine lobe in the direction before the transformation, times the change of solid angle.
    pub fn density(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let Lobe { stretch, shift, .. } = self.lobe(wo.z);
        let along = if wo.truncate().length() > 1.0e-6 { wo.truncate().normalize() } else { DVec2::X };
        let local = DMat2::from_cols(along, along.perp()).transpose() * wi.truncate();
        let before = (stretch * local + shift * wi.z * DVec2::X).extend(wi.z);
        let cosine = wi.z / before.length();
        cosine / PI * stretch.powi(2) / before.length().powi(3)
    }
}
