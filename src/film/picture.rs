//! A finished picture with everything that is measured per pixel. CPU only.

use crate::film::features::{ALBEDO, DEPTH, FEATURES, MeanOver, NORMAL};
use crate::film::sums::{PixelMeans, PixelSums};
use crate::film::view::View;
use crate::generated::layout::{FilmFeatures, FilmRadiance};
use crate::image::Image;

/// Results of a render for every pixel of its window, row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Width of the rendered window in pixels.
    pub width: u32,
    /// Height of the rendered window in pixels.
    pub height: u32,
    /// The window's offset within the whole film.
    pub offset: [u32; 2],
    /// Size of the whole film.
    pub full_size: [u32; 2],
    /// Mean radiance, linear sRGB.
    pub radiance: Vec<[f32; 3]>,
    /// Variance of the mean radiance, computed as if samples were independent (samples in sets have less). 0 where
    /// fewer than two samples were taken.
    pub variance: Vec<[f32; 3]>,
    /// Number of samples taken.
    pub sample_count: Vec<u32>,
    /// Number of samples whose camera ray hit a surface.
    pub hit_count: Vec<u32>,
    /// Means of the features of the first hit, in the order of [`FEATURES`]: values pixel by pixel, one for each channel.
    pub features: [Vec<f32>; FEATURES.len()],
    /// Exact integer sums of all layers, where the picture is one part of several; empty otherwise.
    pub sums: Vec<PixelSums>,
    /// Whether a camera ray that hits no surface shows the environment. Such a picture is opaque everywhere.
    pub has_background: bool,
    /// Matrices of the camera, where there is one.
    pub view: Option<View>,
}

impl Picture {
    /// Empty picture of a window of `width` x `height` pixels that begins at `offset` within a film of `full_size`.
    pub fn empty(width: u32, height: u32, offset: [u32; 2], full_size: [u32; 2]) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            offset,
            full_size,
            radiance: vec![[0.0; 3]; pixels],
            variance: vec![[0.0; 3]; pixels],
            sample_count: vec![0; pixels],
            hit_count: vec![0; pixels],
            features: FEATURES
                .each_ref()
                .map(|feature| vec![feature.mean.of_nothing(); pixels * feature.channels.len()]),
            sums: Vec::new(),
            has_background: false,
            view: None,
        }
    }

    /// Writes every layer of pixel `at` but its sums.
    pub fn set_pixel(&mut self, at: usize, means: &PixelMeans) {
        let PixelMeans { radiance, variance, features, sample_count, hit_count } = *means;
        (self.radiance[at], self.variance[at]) = (radiance, variance);
        (self.sample_count[at], self.hit_count[at]) = (sample_count, hit_count);
        let mut rest = &features[..];
        for (feature, values) in FEATURES.iter().zip(&mut self.features) {
            let (own, others) = rest.split_at(feature.channels.len());
            values[at * own.len()..][..own.len()].copy_from_slice(own);
            rest = others;
        }
    }

    /// Writes every layer of pixel `at` but its sums, from moments on the film. The variance of the mean is `variance_scale` times
    /// the sum of squared deviations.
    pub fn set_moments(&mut self, at: usize, radiance: &FilmRadiance, film: &FilmFeatures, variance_scale: f32) {
        self.radiance[at] = radiance.mean;
        self.variance[at] = radiance.squared_deviation.map(|squared| squared * variance_scale);
        (self.sample_count[at], self.hit_count[at]) = (radiance.sample_count, radiance.hit_count);
        for (feature, values) in FEATURES.iter().zip(&mut self.features) {
            let is_known = feature.mean == MeanOver::Samples || radiance.hit_count > 0;
            let channels = feature.channels.len();
            for (value, &mean) in values[at * channels..][..channels].iter_mut().zip((feature.of_film)(film)) {
                *value = if is_known { mean } else { feature.mean.of_nothing() };
            }
        }
    }

    /// Mean albedo of the first hit; a miss counts as 0.
    pub fn albedo(&self) -> &[[f32; 3]] {
        bytemuck::cast_slice(&self.features[ALBEDO])
    }

    /// Mean shading normal of the first hit, in world space, not normalized.
    pub fn normal(&self) -> &[[f32; 3]] {
        bytemuck::cast_slice(&self.features[NORMAL])
    }

    /// Mean distance from the camera to the first hit in scene units, over the samples that hit; infinite where none did.
    pub fn depth(&self) -> &[f32] {
        &self.features[DEPTH]
    }

    /// The picture's pixels: mean radiance in linear sRGB, row by row from the top left.
    pub fn rgb(&self) -> &[[f32; 3]] {
        &self.radiance
    }

    /// Share of pixel `at` that is opaque, in [0, 1]: the share of its samples that hit a surface. If an environment is seen
    /// behind the surfaces, every sample is opaque, as in Mitsuba.
    pub fn alpha(&self, at: usize) -> f32 {
        match self.sample_count[at] {
            0 => 0.0,
            _ if self.has_background => 1.0,
            samples => (f64::from(self.hit_count[at]) / f64::from(samples)) as f32,
        }
    }

    /// The mean radiance as an image.
    pub fn image(&self) -> Image {
        self.with_pixels(&self.radiance)
    }

    /// The variance of the mean radiance as an image.
    pub fn variance_image(&self) -> Image {
        self.with_pixels(&self.variance)
    }

    fn with_pixels(&self, pixels: &[[f32; 3]]) -> Image {
        Image { width: self.width, height: self.height, pixels: pixels.to_vec() }
    }
}
