//! Scenes as a path tracer needs them: read from Mitsuba's files and flattened. CPU only: no Vulkan, no `unsafe`.
//!
//! Conventions are Mitsuba's. The world is right-handed. The texture coordinate `v` is 0 at the image's *top* row. The
//! camera looks along its `+z`, with `+x` to the *left* of the picture. Depth is counted in path edges (1 is emission
//! seen directly).

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
pub mod texture_lookup;

use glam::{Mat4, Vec2, Vec3};

pub use bsdf::{Bsdf, Material, MaterialKind, SurfaceMaterial};
pub use build::Surface;
pub use emitter::{AreaEmitter, DeltaEmitter, DeltaKind, Environment, EnvironmentKind};
pub use fingerprint::fingerprint;
pub use geometry::{Primitive, PrimitiveShape};
pub use mitsuba::load::{LoadOptions, LoadProgress, load, load_with_progress};
pub use texture::{Image, Texture, Textured};

/// Whole scene in world space.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Name of the scene: its file's stem, or its folder's name where the stem is `scene`.
    pub name: String,
    /// The scene's only camera.
    pub camera: Camera,
    /// The sensor's film.
    pub film: FilmDescription,
    /// Settings of the scene file's integrator.
    pub integrator: IntegratorDescription,
    /// `sample_count` of the sensor's sampler.
    pub sample_count: Option<u32>,
    /// All shapes, flattened to world-space primitives, in file order.
    pub primitives: Vec<Primitive>,
    /// Materials that primitives refer to by index, and materials that choose between others.
    pub materials: Vec<Material>,
    /// Area emitters, which primitives refer to by index.
    pub emitters: Vec<AreaEmitter>,
    /// Light from infinitely far away.
    pub environment: Option<Environment>,
    /// Emitters that no ray can hit.
    pub delta_emitters: Vec<DeltaEmitter>,
    /// Textures, which materials and emitters refer to by index.
    pub textures: Vec<Texture>,
    /// Images, which textures and the environment refer to by index.
    pub images: Vec<Image>,
    /// Warnings about things that were read but are not rendered exactly, one sentence each, with file and line.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Smallest axis-aligned box that holds all primitives, as (minimum, maximum); `None` for an empty scene.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let boxes = self.primitives.iter().map(Primitive::bounds);
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

/// Camera of a scene.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Camera {
    /// Kind of projection.
    pub projection: Projection,
    /// Transform from camera space (x left, y up, z forward) to the world. A rigid motion unless the projection is
    /// orthographic.
    pub world_from_camera: Mat4,
    /// Field of view in degrees, in (0, 180), along `fov_axis`. Unused by an orthographic projection.
    pub fov: f32,
    /// Axis that `fov` spans.
    pub fov_axis: FovAxis,
    /// Offset of the principal point, in picture widths and heights: the pixel at `(x, y)`, from the top left corner in
    /// the same units, looks along `((1 - 2 (x + offset.x)) tan_x, (1 - 2 (y + offset.y)) tan_y, 1)` in camera space.
    pub principal_point: Vec2,
    /// Distance of the near plane, > 0, scene units.
    pub near_clip: f32,
    /// Distance of the far plane, > near, scene units.
    pub far_clip: f32,
}

/// Projections of a camera.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum Projection {
    /// Perspective: all rays go through one point.
    Perspective,
    /// Thin lens: all rays go through a disk around the origin of camera space. The plane at depth `focus_distance` is
    /// sharp.
    ThinLens {
        /// Radius of the lens, > 0, scene units.
        aperture_radius: f32,
        /// Depth of the plane in focus, > 0, scene units.
        focus_distance: f32,
    },
    /// Orthographic: all rays are parallel to camera space's z axis. The picture's width spans x from -1 to 1 there.
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
    /// Half the width and height, in camera units, of the part of the plane at depth 1 that a picture of `width` x
    /// `height` pixels shows.
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
    /// Window of the film that is rendered; `None` for the whole film.
    pub crop: Option<Crop>,
    /// Reconstruction filter.
    pub filter: ReconstructionFilter,
}

/// Window of the film, in pixels from its top left corner.
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

/// Reconstruction filter, applied by filter importance sampling. Radii are in pixels.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReconstructionFilter {
    /// Box filter: each sample counts equally within its own pixel.
    Box,
    /// Tent filter of the given radius (Mitsuba's default: 1).
    Tent {
        /// Radius at which the tent reaches zero.
        radius: f32,
    },
    /// Gaussian filter of the given standard deviation (Mitsuba's default: 0.5), cut off at four standard deviations,
    /// as in Mitsuba.
    Gaussian {
        /// Standard deviation.
        stddev: f32,
    },
}

/// Settings of the scene file's `integrator`; `None` where it leaves them open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct IntegratorDescription {
    /// Longest path in edges; `Some(-1)` is Mitsuba's "unlimited".
    pub max_depth: Option<i32>,
    /// Depth from which Russian roulette is played.
    pub rr_depth: Option<i32>,
    /// Whether directly seen emission is left out, including the environment's.
    pub hide_emitters: bool,
}
