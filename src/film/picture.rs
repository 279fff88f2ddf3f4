//! A finished picture with everything measured per pixel. CPU only.

use crate::film::sums::PixelSums;
use crate::image::Image;

/// What a render leaves for every pixel of its window, row by row from the top left.
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
    /// Variance of that mean, were its samples independent (those in sets leave less); 0 where fewer than two
    /// were taken.
    pub variance: Vec<[f32; 3]>,
    /// Samples taken.
    pub sample_count: Vec<u32>,
    /// Those of them whose camera ray hit something.
    pub hit_count: Vec<u32>,
    /// Mean albedo of the first hit (0 where it misses).
    pub albedo: Vec<[f32; 3]>,
    /// Mean shading normal of the first hit, world space, not normalised.
    pub normal: Vec<[f32; 3]>,
    /// Mean distance from the camera to the first hit in scene units, over the samples that hit; infinite where none does.
    pub depth: Vec<f32>,
    /// What all of these were computed from, where the picture is one part of several; empty elsewhere.
    pub sums: Vec<PixelSums>,
}

impl Picture {
    /// A picture of nothing, of the window of that size at that offset within the film.
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
            albedo: vec![[0.0; 3]; pixels],
            normal: vec![[0.0; 3]; pixels],
            depth: vec![f32::INFINITY; pixels],
            sums: Vec::new(),
        }
    }

    /// The picture's pixels: mean radiance in linear sRGB, row by row from the top left.
    pub fn rgb(&self) -> &[[f32; 3]] {
        &self.radiance
    }

    /// The mean radiance alone.
    pub fn image(&self) -> Image {
        self.with_pixels(&self.radiance)
    }

    /// The variance of the mean, as a picture of the same size.
    pub fn variance_image(&self) -> Image {
        self.with_pixels(&self.variance)
    }

    fn with_pixels(&self, pixels: &[[f32; 3]]) -> Image {
        Image { width: self.width, height: self.height, pixels: pixels.to_vec() }
    }
}
