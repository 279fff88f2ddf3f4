//! Textures as they are reduced, and their mappings.

use std::path::PathBuf;
use std::rc::Rc;

use glam::{DMat3, DMat4, DVec2, DVec3};

use super::rasters::{Encoding, Raster, Sampling};
use crate::image::texels::TexelImage;
use crate::scene::description::make::matrix;
use crate::scene::description::object::Value;

/// Texture reduced as far as it can be. Numbers are gray colors.
#[derive(Debug, Clone)]
pub(super) enum Node {
    Constant([f64; 3]),
    /// Two colors in turn: the first where the whole parts of both coordinates have an even sum.
    Checkerboard {
        colors: [[f64; 3]; 2],
        to_uv: DMat3,
    },
    /// Image of a file, times a factor.
    Image {
        image: ImageFile,
        factor: f64,
    },
    /// Texture that kernels compute.
    Computed {
        /// Id of the object.
        id: String,
        /// Approximate mean.
        mean: [f64; 3],
    },
    /// Image that was computed.
    Raster {
        raster: Rc<Raster>,
        sampling: Sampling,
    },
}

impl Node {
    /// Approximate mean. That of an image is not known before it is decoded.
    pub fn rough_mean(&self) -> DVec3 {
        match self {
            Self::Constant(color) => (*color).into(),
            Self::Checkerboard { colors: [first, second], .. } => 0.5 * (DVec3::from(*first) + DVec3::from(*second)),
            Self::Computed { mean, .. } => (*mean).into(),
            Self::Image { factor, .. } => DVec3::splat(0.5 * factor),
            Self::Raster { raster, .. } => raster.mean().as_dvec3(),
        }
    }
}

/// Image file as a texture uses it.
#[derive(Debug, Clone)]
pub(super) struct ImageFile {
    /// Name that a `bitmap` has.
    pub name: String,
    pub source: Source,
    pub encoding: Encoding,
    pub sampling: Sampling,
}

/// Place of an image's texels.
#[derive(Debug, Clone)]
pub(super) enum Source {
    File(PathBuf),
    Memory(Rc<TexelImage>),
}

/// Color in linear sRGB.
pub(super) fn rgb(color: [f64; 3]) -> Value {
    Value::Rgb(color)
}

/// The mapping with `v` from the image's top, which in pbrt runs from its bottom.
pub(super) fn flipped(mapping: DMat3) -> DMat3 {
    DMat3::from_translation(DVec2::Y) * DMat3::from_scale(DVec2::new(1.0, -1.0)) * mapping
}

/// Transform of texture coordinates.
pub(super) fn planar(to_uv: &DMat3) -> Value {
    let column = |column: DVec3, last: f64| column.truncate().extend(0.0).extend(last);
    let columns = [column(to_uv.x_axis, 0.0), column(to_uv.y_axis, 0.0), glam::DVec4::Z, column(to_uv.z_axis, 1.0)];
    matrix(&DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]))
}
