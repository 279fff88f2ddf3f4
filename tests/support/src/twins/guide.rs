//! Twin of the densities in `glsl/include/guide/samplers/rejection_mix.glsl`, `sphere_inversion.glsl`,
//! `hemisphere_inversion.glsl` and `product.glsl`.

use std::f64::consts::PI;

use glam::DVec3;
use lodestar::settings::{DirectionMap, Sampler};

use super::direction_map::direction_bin;
use super::normalization_entry::{NormalizationEntry, Rules};
use super::product::Product;

/// Cell, surface normal and rules of the sampler that draws there.
#[derive(Debug, Clone, Copy)]
pub struct Guide<'a> {
    /// Sampler and its constants.
    pub rules: &'a Rules,
    /// Map between directions and bins.
    pub map: DirectionMap,
    /// Radiance of every bin.
    pub radiance: &'a [f32],
    /// Integral over every bin of the clamped cosine about `nb`, sr.
    pub integrals: &'a [f64],
    /// Representative normal.
    pub nb: DVec3,
    /// True normal.
    pub n: DVec3,
    /// Factors that follow from the normalizers in double precision.
    pub entry: NormalizationEntry,
}

/// Density of the guide within one bin: `times_cosine max(0, nb.w) + constant + above [nb.w > 0]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BinDensity {
    /// Factor of the clamped cosine about the representative normal.
    pub times_cosine: f64,
    /// Density in the whole bin.
    pub constant: f64,
    /// Density on the hemisphere of the representative normal.
    pub above: f64,
}

impl Guide<'_> {
    /// Bins along each side of the map.
    pub fn resolution(&self) -> u32 {
        self.radiance.len().isqrt() as u32
    }

    /// Density in a bin, without the uniform share.
    pub fn bin_density(&self, bin: usize) -> BinDensity {
        let (radiance, scale) = (f64::from(self.radiance[bin]), self.entry.guide_scale);
        match self.rules.sampler {
            Sampler::SphereInversion => BinDensity { constant: scale * radiance, ..BinDensity::default() },
            Sampler::HemisphereInversion => {
                BinDensity { constant: scale * radiance * self.integrals[bin], ..BinDensity::default() }
            }
            Sampler::Product => BinDensity { constant: scale * self.product().density(bin), ..BinDensity::default() },
            _ if self.rules.mixes_acceptances() => BinDensity {
                times_cosine: scale * self.entry.acceptance_scale * radiance,
                above: scale * self.entry.uniform_share,
                ..BinDensity::default()
            },
            _ => BinDensity { times_cosine: scale * radiance, ..BinDensity::default() },
        }
    }

    fn product(&self) -> Product<'_> {
        Product { radiance: self.radiance, integrals: self.integrals }
    }

    /// Share of samples drawn by the cosine about the true normal.
    pub fn cosine_share(&self) -> f64 {
        if self.rules.sampler == Sampler::Product { self.entry.uniform_share } else { 0.0 }
    }

    /// Density with which the product sampler's descent alone draws `wi`.
    pub fn descent(&self, wi: DVec3) -> f64 {
        self.product().density(direction_bin(self.map, wi, self.resolution()) as usize)
    }

    /// Density of `wi`, per steradian.
    pub fn pdf(&self, wi: DVec3) -> f64 {
        let density = self.bin_density(direction_bin(self.map, wi, self.resolution()) as usize);
        let cosine = wi.dot(self.nb);
        let above = if cosine > 0.0 { density.above } else { 0.0 };
        let uniform = if wi.dot(self.n) > 0.0 { self.entry.uniform_density } else { 0.0 };
        let of_cosine = self.cosine_share() * wi.dot(self.n).max(0.0) / PI;
        density.times_cosine * cosine.max(0.0) + density.constant + above + uniform + of_cosine
    }
}
