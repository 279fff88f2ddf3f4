//! Textures: what varies over a surface.

use glam::{Mat3, Vec3};

/// A value, or a texture times that value.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Textured<T> {
    /// The value, or the factor of the texture.
    pub value: T,
    /// Index into `Scene::textures`.
    pub texture: Option<u32>,
}

impl<T> Textured<T> {
    /// A value that is the same everywhere.
    pub fn constant(value: T) -> Self {
        Self { value, texture: None }
    }
}

/// A texture with its mapping.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Texture {
    /// Its `id` or file, for messages.
    #[serde(skip)]
    pub name: String,
    /// What it shows.
    pub pattern: Pattern,
    /// Texture coordinates from the surface's, in homogeneous coordinates (`to_uv`).
    pub to_uv: Mat3,
}

/// Of a large image at most this many texels, evenly spread, stand for all.
const MEAN_TEXELS: usize = 1 << 14;

impl Texture {
    /// About the mean color, linear: good enough for shares of samples.
    pub fn mean(&self, images: &[Image]) -> Vec3 {
        match self.pattern {
            Pattern::Checkerboard { color0, color1 } => 0.5 * (color0 + color1),
            Pattern::Bitmap { image, .. } => {
                let texels = &images[image as usize].texels;
                let step = texels.len().div_ceil(MEAN_TEXELS).max(1);
                texels.colors(step).sum::<Vec3>() / texels.len().div_ceil(step).max(1) as f32
            }
        }
    }

    /// The largest value of each channel, linear.
    pub fn maximum(&self, images: &[Image]) -> Vec3 {
        match self.pattern {
            Pattern::Checkerboard { color0, color1 } => color0.max(color1),
            Pattern::Bitmap { image, .. } => images[image as usize].texels.colors(1).fold(Vec3::ZERO, Vec3::max),
        }
    }
}

/// What a texture shows.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum Pattern {
    /// An image.
    Bitmap {
        /// Index into `Scene::images`.
        image: u32,
        /// How values between texels come about.
        filter: TexelFilter,
        /// What lies beyond the image.
        wrap: WrapMode,
    },
    /// Two colors in turn, each on half a unit of `u` and of `v`.
    Checkerboard {
        /// Where both coordinates' fractions lie on the same side of one half, linear sRGB.
        color0: Vec3,
        /// Elsewhere, linear sRGB.
        color1: Vec3,
    },
}

/// Mitsuba's `filter_type`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum TexelFilter {
    /// Interpolated between four texels' centers (Mitsuba's default).
    Bilinear,
    /// The nearest texel.
    Nearest,
}

/// Mitsuba's `wrap_mode`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum WrapMode {
    /// The image is repeated (Mitsuba's default).
    Repeat,
    /// Every other copy is mirrored.
    Mirror,
    /// The border's texels go on.
    Clamp,
}

/// An image as a texture reads it, rows from the top.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Image {
    /// The file, for messages.
    #[serde(skip)]
    pub name: String,
    /// Texels in a row, > 0.
    pub width: u32,
    /// Rows, > 0.
    pub height: u32,
    /// `width * height` of them.
    pub texels: Texels,
}

/// Texels in the precision that their file has.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum Texels {
    /// Red, green, blue and alpha in [0, 255]; gray is in all three.
    Bytes {
        /// Whether the colors (not alpha) are encoded by the sRGB curve.
        srgb: bool,
        /// The texels.
        #[serde(serialize_with = "as_bytes")]
        data: Vec<[u8; 4]>,
    },
    /// Linear red, green, blue and alpha, finite.
    Floats(#[serde(serialize_with = "as_bytes")] Vec<[f32; 4]>),
}

/// In one piece: one by one, the hash of a large image would take seconds.
fn as_bytes<T: bytemuck::Pod, S: serde::Serializer>(texels: &[T], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(bytemuck::cast_slice(texels))
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::Bytes { data, .. } => data.len(),
            Self::Floats(data) => data.len(),
        }
    }

    /// Every `step`th color, linear but for what a power of 2.2 differs from the sRGB curve.
    fn colors(&self, step: usize) -> Box<dyn Iterator<Item = Vec3> + '_> {
        let power = |srgb: bool| if srgb { 2.2 } else { 1.0 };
        match self {
            Self::Floats(data) => Box::new(data.iter().step_by(step.max(1)).map(|[r, g, b, _]| Vec3::new(*r, *g, *b))),
            Self::Bytes { srgb, data } => {
                let linear = move |[r, g, b, _]: &[u8; 4]| {
                    Vec3::from([*r, *g, *b].map(|byte| (f32::from(byte) / 255.0).powf(power(*srgb))))
                };
                Box::new(data.iter().step_by(step.max(1)).map(linear))
            }
        }
    }
}
