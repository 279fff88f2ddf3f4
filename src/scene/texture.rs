//! Textures: values that vary over a surface.

use glam::{Mat3, Vec3};

use super::program::Program;

/// Value, or texture times a value.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Textured<T> {
    /// The value, or the factor of the texture.
    pub value: T,
    /// Index into `Scene::textures`; `None` for a constant.
    pub texture: Option<u32>,
}

impl<T> Textured<T> {
    /// Value that is constant over the surface.
    pub fn constant(value: T) -> Self {
        Self { value, texture: None }
    }
}

/// Texture with its mapping.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Texture {
    /// The texture's `id` or file, for messages.
    #[serde(skip)]
    pub name: String,
    /// Pattern of the texture.
    pub pattern: Pattern,
    /// Texture coordinates from the surface's, in homogeneous coordinates (`to_uv`).
    pub to_uv: Mat3,
}

/// Most texels that the mean of a large image is taken over; they are evenly spread.
const MEAN_TEXELS: usize = 1 << 14;

impl Texture {
    /// Approximate mean color, linear. It is accurate enough to share out samples.
    pub fn mean(&self, images: &[Image]) -> Vec3 {
        match &self.pattern {
            Pattern::Checkerboard { color0, color1 } => 0.5 * (*color0 + *color1),
            Pattern::Program(program) => program.mean,
            Pattern::Bitmap { image, .. } => {
                let texels = &images[*image as usize].texels;
                let step = texels.len().div_ceil(MEAN_TEXELS).max(1);
                texels.colors(step).sum::<Vec3>() / texels.len().div_ceil(step).max(1) as f32
            }
        }
    }

    /// Largest value of each channel, linear.
    pub fn maximum(&self, images: &[Image]) -> Vec3 {
        match &self.pattern {
            Pattern::Checkerboard { color0, color1 } => color0.max(*color1),
            Pattern::Program(program) => Vec3::splat(program.limits[1]),
            Pattern::Bitmap { image, .. } => images[*image as usize].texels.colors(1).fold(Vec3::ZERO, Vec3::max),
        }
    }
}

/// Patterns of a texture.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum Pattern {
    /// Image.
    Bitmap {
        /// Index into `Scene::images`.
        image: u32,
        /// Interpolation between texels.
        filter: TexelFilter,
        /// Continuation beyond the image.
        wrap: WrapMode,
    },
    /// Checkerboard: two colors in turn, each on half a unit of `u` and of `v`.
    Checkerboard {
        /// Color where both coordinates' fractions lie on the same side of one half, linear sRGB.
        color0: Vec3,
        /// Color elsewhere, linear sRGB.
        color1: Vec3,
    },
    /// Texture that is computed.
    Program(Program),
}

/// Interpolations between texels: Mitsuba's `filter_type`, and `decode_after_filter`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum TexelFilter {
    /// Linear interpolation between four texels' centers (Mitsuba's default).
    Bilinear,
    /// Nearest texel.
    Nearest,
    /// Linear interpolation between the encoded colors of four texels, each of which counts by its alpha. The mix is decoded by the
    /// sRGB curve, as in Cycles. Where colors are not bytes that the curve encodes, it is [`TexelFilter::Bilinear`].
    Encoded,
}

/// Continuations beyond the image: Mitsuba's `wrap_mode`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum WrapMode {
    /// Repetition of the image (Mitsuba's default).
    Repeat,
    /// Repetition in which every other copy is mirrored.
    Mirror,
    /// Continuation of the border's texels.
    Clamp,
}

/// Image as a texture reads it, rows from the top.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Image {
    /// Path of the file, for messages.
    #[serde(skip)]
    pub name: String,
    /// Number of texels in a row, > 0.
    pub width: u32,
    /// Number of rows, > 0.
    pub height: u32,
    /// `width * height` texels, row by row.
    pub texels: Texels,
}

/// Texels in the precision of their file.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum Texels {
    /// Red, green, blue and alpha in [0, 255]; gray stands in all three color channels.
    Bytes {
        /// Whether the colors (not alpha) are encoded by the sRGB curve.
        srgb: bool,
        /// Texels, row by row.
        #[serde(serialize_with = "as_bytes")]
        data: Vec<[u8; 4]>,
    },
    /// Linear red, green, blue and alpha, finite. Kernels read them as halves.
    Floats(#[serde(serialize_with = "as_bytes")] Vec<[f32; 4]>),
    /// Heights of a bump map, finite. Kernels read them as they are, because halves would quantize the slopes.
    Heights(#[serde(serialize_with = "as_bytes")] Vec<f32>),
}

/// Serializes texels as one block of bytes. One by one, the hash of a large image would take seconds.
fn as_bytes<T: bytemuck::Pod, S: serde::Serializer>(texels: &[T], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(bytemuck::cast_slice(texels))
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::Bytes { data, .. } => data.len(),
            Self::Floats(data) => data.len(),
            Self::Heights(data) => data.len(),
        }
    }

    /// Every `step`th color, decoded to linear by a power of 2.2 in place of the sRGB curve.
    fn colors(&self, step: usize) -> Box<dyn Iterator<Item = Vec3> + '_> {
        let power = |srgb: bool| if srgb { 2.2 } else { 1.0 };
        match self {
            Self::Floats(data) => Box::new(data.iter().step_by(step.max(1)).map(|[r, g, b, _]| Vec3::new(*r, *g, *b))),
            Self::Heights(data) => Box::new(data.iter().step_by(step.max(1)).map(|&height| Vec3::splat(height))),
            Self::Bytes { srgb, data } => {
                let linear = move |[r, g, b, _]: &[u8; 4]| {
                    Vec3::from([*r, *g, *b].map(|byte| (f32::from(byte) / 255.0).powf(power(*srgb))))
                };
                Box::new(data.iter().step_by(step.max(1)).map(linear))
            }
        }
    }
}
