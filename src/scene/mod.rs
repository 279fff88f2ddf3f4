//! A Mitsuba scene, read and flattened to what a path tracer needs. CPU only: no Vulkan, no `unsafe`.
//!
//! Conventions are Mitsuba's: right-handed world, `v` of a texture coordinate 0 at the image's *top* row, camera looking along its
//! `+z` with `+x` to the *left* of the picture, depth counted in path edges (1 is emission seen directly).

pub mod bsdf;
mod build;
pub mod emitter;
pub mod fingerprint;
pub mod geometry;
mod mesh;
pub mod mitsuba;
mod shrink;
pub mod texel_pages;
pub mod texture;

use glam::{Mat4, Vec2, Vec3};

pub use bsdf::{Bsdf, Material, MaterialKind, SurfaceMaterial};
pub use build::Surface;
pub use emitter::{AreaEmitter, DeltaEmitter, DeltaKind, Environment, EnvironmentKind};
pub use fingerprint::fingerprint;
pub use geometry::{Primitive, PrimitiveShape};
pub use mitsuba::load::{LoadOptions, LoadProgress, load, load_with_progress};
pub use texture::{Image, Texture, Textured};

/// A whole scene in world space.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The scene's name: its file's stem, or its folder's name where the stem is `scene`.
    pub name: String,
    /// The one sensor.
    pub camera: Camera,
    /// The sensor's film.
    pub film: FilmDescription,
    /// What the scene file says of the integrator.
    pub integrator: IntegratorDescription,
    /// `sample_count` of the sensor's sampler.
    pub sample_count: Option<u32>,
    /// Every shape, flattened to world-space primitives, in file order.
    pub primitives: Vec<Primitive>,
    /// What primitives index as `material`, and materials that choose between others.
    pub materials: Vec<Material>,
    /// What primitives index as `emitter`: area emitters.
    pub emitters: Vec<AreaEmitter>,
    /// Light from infinitely far away.
    pub environment: Option<Environment>,
    /// Emitters that no ray can hit.
    pub delta_emitters: Vec<DeltaEmitter>,
    /// What materials and emitters index as textures.
    pub textures: Vec<Texture>,
    /// What textures and the environment index as images.
    pub images: Vec<Image>,
    /// What was read but is not honoured exactly, one sentence each, with file and line.
    pub warnings: Vec<String>,
}

impl Scene {
    /// The smallest axis-aligned box that holds all primitives, as (minimum, maximum); `None` for an empty scene.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let boxes = self.primitives.iter().map(Primitive::bounds);
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

/// A sensor.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Camera {
    /// How it projects.
    pub projection: Projection,
    /// Camera space (x left, y up, z forward) to world. A rigid motion unless the projection is orthographic.
    pub world_from_camera: Mat4,
    /// Field of view in degrees, in (0, 180), along `fov_axis`; it means nothing to an orthographic projection.
    pub fov: f32,
    /// The axis that `fov` spans.
    pub fov_axis: FovAxis,
    /// Offset of the principal point, in picture widths and heights: the pixel at `(x, y)`, from the top left corner in
    /// the same units, looks along `((1 - 2 (x + offset.x)) tan_x, (1 - 2 (y + offset.y)) tan_y, 1)` in camera space.
    pub principal_point: Vec2,
    /// Distance of the near plane, > 0.
    pub near_clip: f32,
    /// Distance of the far plane, > near.
    pub far_clip: f32,
}

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum Projection {
    /// All rays go through one point.
    Perspective,
    /// All rays go through a lens, a disk around the origin of camera space; what lies in the plane at the depth
    /// `focus_distance` is sharp.
    ThinLens {
        /// Radius of the lens, > 0, scene units.
        aperture_radius: f32,
        /// Depth of the plane in focus, > 0, scene units.
        focus_distance: f32,
    },
    /// All rays run along camera space's z axis; the picture's width spans x from -1 to 1 there.
    Orthographic,
}

/// Mitsuba's `fov_axis`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum FovAxis {
    /// Horizontal (Mitsuba's default).
    X,
    /// Vertical.
    Y,
    /// The picture's diagonal.
    Diagonal,
    /// The shorter side.
    Smaller,
    /// The longer side.
    Larger,
}

impl Camera {
    /// Half the width and height, in camera units, of what a picture of `width` x `height` pixels shows of the plane at
    /// depth 1.
    pub fn half_extent(&self, width: u32, height: u32) -> Vec2 {
        let half_width = match self.projection {
            Projection::Orthographic => 1.0,
            _ => self.tan_half_fov_x(width, height),
        };
        Vec2::new(half_width, half_width * height as f32 / width as f32)
    }

    /// Tangent of half the *horizontal* field of view for a picture of `width` x `height` pixels.
    pub fn tan_half_fov_x(&self, width: u32, height: u32) -> f32 {
        let (width, height) = (width as f32, height as f32);
        let tan_half = (0.5 * self.fov.to_radians()).tan();
        let vertical = tan_half * width / height;
        match self.fov_axis {
            FovAxis::X => tan_half,
            FovAxis::Y => vertical,
            FovAxis::Diagonal => tan_half * width / width.hypot(height),
            FovAxis::Smaller => {
                if width < height {
                    tan_half
                } else {
                    vertical
                }
            }
            FovAxis::Larger => {
                if width > height {
                    tan_half
                } else {
                    vertical
                }
            }
        }
    }
}

/// Size, crop and reconstruction filter of a film.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FilmDescription {
    /// Width in pixels, > 0.
    pub width: u32,
    /// Height in pixels, > 0.
    pub height: u32,
    /// The window of it that is rendered, where the file names one.
    pub crop: Option<Crop>,
    /// The reconstruction filter.
    pub filter: ReconstructionFilter,
}

/// A window of the film, in pixels from its top left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Crop {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Width, > 0.
    pub width: u32,
    /// Height, > 0.
    pub height: u32,
}

/// A reconstruction filter, applied by filter importance sampling. Radii are in pixels.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReconstructionFilter {
    /// Every sample weighs the same within its own pixel.
    Box,
    /// A tent of the given radius (Mitsuba's default: 1).
    Tent {
        /// Where the tent reaches zero.
        radius: f32,
    },
    /// A Gaussian of the given standard deviation (Mitsuba's default: 0.5), cut off at four of them, as Mitsuba does.
    Gaussian {
        /// Standard deviation.
        stddev: f32,
    },
}

/// What the scene file's `integrator` says; what it leaves open is `None`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct IntegratorDescription {
    /// Longest path in edges; `Some(-1)` is Mitsuba's "unlimited".
    pub max_depth: Option<i32>,
    /// Depth from which Russian roulette is played.
    pub rr_depth: Option<i32>,
    /// Whether emission is left out where it is seen directly, the environment's too.
    pub hide_emitters: bool,
}
