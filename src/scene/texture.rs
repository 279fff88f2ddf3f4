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
