//! Images in memory: what textures are computed from, and what they become.

use std::rc::Rc;

use glam::{DMat3, Vec3};

use crate::image::Image;
use crate::image::texels::{FileTexels, TexelImage};
use crate::math::srgb::linear_from_srgb;

/// Meaning of the numbers of an image with whole numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    Srgb,
    Linear,
    Gamma(f64),
}

/// Mapping of an image onto a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sampling {
    /// Image coordinates from the surface's. The image's top row lies at 0.
    pub to_uv: DMat3,
    /// Mitsuba's name of the continuation beyond the image.
    pub wrap: &'static str,
    /// Mitsuba's name of the interpolation.
    pub filter: &'static str,
}

/// Linear colors, row by row from the top.
#[derive(Debug)]
pub(super) struct Raster {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<Vec3>,
}

impl Raster {
    /// Colors of an image. Numbers of a file of floating-point numbers are linear already.
    pub fn of(image: &TexelImage, encoding: Encoding) -> Self {
        let (width, height) = (image.width as usize, image.height as usize);
        let color = |texel: [f32; 4]| Vec3::new(texel[0], texel[1], texel[2]);
        let decode = |value: f64| match encoding {
            Encoding::Srgb => linear_from_srgb(value) as f32,
            Encoding::Linear => value as f32,
            Encoding::Gamma(gamma) => value.powf(gamma) as f32,
        };
        let texels = match &image.texels {
            FileTexels::Bytes(data) => {
                let table: Vec<f32> = (0..256).map(|byte| decode(f64::from(byte) / 255.0)).collect();
                let texel = |texel: &[u8; 4]| color(texel.map(|byte| table[usize::from(byte)]));
                data.iter().map(texel).collect()
            }
            FileTexels::Encoded(data) => data.iter().map(|texel| color(texel.map(|x| decode(f64::from(x))))).collect(),
            FileTexels::Linear(data) => data.iter().map(|texel| color(*texel)).collect(),
        };
        Self { width, height, texels }
    }

    /// Raster of the results of a function of each color.
    pub fn map(&self, change: impl Fn(Vec3) -> Vec3) -> Self {
        Self {
            width: self.width,
            height: self.height,
            texels: self.texels.iter().map(|&texel| change(texel)).collect(),
        }
    }

    /// Raster of another size. A larger one repeats texels or interpolates them, as `filter` says.
    pub fn resized(self: &Rc<Self>, width: usize, height: usize, sampling: &Sampling) -> Rc<Self> {
        if (self.width, self.height) == (width, height) {
            return Rc::clone(self);
        }
        let texels = (0..width * height).map(|at| {
            let place = |at: usize, count: usize, own: usize| (at as f64 + 0.5) / count as f64 * own as f64;
            let (x, y) = (place(at % width, width, self.width), place(at / width, height, self.height));
            if sampling.filter == "nearest" {
                self.texel(x.floor(), y.floor(), sampling)
            } else {
                self.bilinear(x, y, sampling)
            }
        });
        Rc::new(Self { width, height, texels: texels.collect() })
    }

    fn bilinear(&self, x: f64, y: f64, sampling: &Sampling) -> Vec3 {
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (u, v) = ((x - 0.5 - left) as f32, (y - 0.5 - top) as f32);
        let row = |y: f64| self.texel(left, y, sampling).lerp(self.texel(left + 1.0, y, sampling), u);
        row(top).lerp(row(top + 1.0), v)
    }

    fn texel(&self, x: f64, y: f64, sampling: &Sampling) -> Vec3 {
        let inside = |at: f64, count: usize| match sampling.wrap {
            "repeat" => at.rem_euclid(count as f64) as usize,
            _ => at.clamp(0.0, count as f64 - 1.0) as usize,
        };
        self.texels[inside(y, self.height) * self.width + inside(x, self.width)]
    }

    /// The raster as a picture.
    pub fn to_image(&self) -> Image {
        let pixels = self.texels.iter().map(|texel| texel.to_array()).collect();
        Image { width: self.width as u32, height: self.height as u32, pixels }
    }

    /// Mean color.
    pub fn mean(&self) -> Vec3 {
        let sum = self.texels.iter().map(|texel| texel.as_dvec3()).sum::<glam::DVec3>();
        (sum / self.texels.len().max(1) as f64).as_vec3()
    }
}

/// Whether all texels are gray and opaque.
pub(super) fn is_gray(image: &TexelImage) -> bool {
    match &image.texels {
        FileTexels::Bytes(data) => data.iter().all(|t| t[0] == t[1] && t[1] == t[2]),
        FileTexels::Encoded(data) | FileTexels::Linear(data) => data.iter().all(|t| t[0] == t[1] && t[1] == t[2]),
    }
}

/// Image of the alpha channel; `None` where all texels are opaque.
pub(super) fn alpha(image: &TexelImage) -> Option<TexelImage> {
    let texels = match &image.texels {
        FileTexels::Bytes(data) if data.iter().any(|t| t[3] != u8::MAX) => {
            FileTexels::Bytes(data.iter().map(|t| [t[3], t[3], t[3], u8::MAX]).collect())
        }
        FileTexels::Encoded(data) if data.iter().any(|t| t[3] != 1.0) => {
            FileTexels::Encoded(data.iter().map(|t| [t[3], t[3], t[3], 1.0]).collect())
        }
        _ => return None,
    };
    Some(TexelImage { texels, ..*image })
}
