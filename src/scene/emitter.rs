//! Emitters of a scene.

use glam::{Mat3, Vec3};

use super::texture::Textured;

/// `area` emitter: it emits from the side to which its normal points.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct AreaEmitter {
    /// Emitted radiance in linear sRGB, W/(m^2 sr), each channel >= 0.
    pub radiance: Textured<Vec3>,
    /// Factor of how often the emitter is sampled, >= 0. At 0, only rays that hit it by chance see it.
    pub sampling_weight: f32,
    /// Cone within which the light leaves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone: Option<Cone>,
}

/// Cone of a `spotarea` emitter. Between its border and that of its beam, the radiance rises smoothly with the cosine of the angle to the
/// axis: by 3 x^2 - 2 x^3, where x rises from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Cone {
    /// Unit axis, away from the light.
    pub axis: Vec3,
    /// Cosine of the half angle beyond which no light leaves.
    pub cos_cutoff: f64,
    /// Cosine of the half angle up to which all light leaves, above `cos_cutoff`.
    pub cos_beam: f64,
}

impl Cone {
    /// Share of the light of an emitter without the cone that leaves through it.
    pub fn share(&self) -> f64 {
        // The mean of the smooth rise is a half.
        0.5 * (1.0 - 0.5 * (self.cos_cutoff + self.cos_beam))
    }
}

impl AreaEmitter {
    /// Emitter that is sampled in proportion to its power.
    pub fn new(radiance: Textured<Vec3>) -> Self {
        Self { radiance, sampling_weight: 1.0, cone: None }
    }
}

/// Light from infinitely far away.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Environment {
    /// Distribution of the light over directions.
    pub kind: EnvironmentKind,
    /// Factor of how often the environment is sampled, >= 0.
    pub sampling_weight: f32,
}

/// Distributions of an environment's light over directions.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum EnvironmentKind {
    /// `constant`: equal radiance from all directions.
    Constant {
        /// Radiance in linear sRGB, W/(m^2 sr), each channel >= 0.
        radiance: Vec3,
    },
    /// `envmap`: a latitude-longitude image.
    Map {
        /// Index into `Scene::images`; the image has at least 2 x 3 texels.
        image: u32,
        /// Factor of the image's radiance, >= 0.
        scale: f32,
        /// Orthogonal transform from the map's space to the world. In the map's space the up axis is `+y` and the map's
        /// center lies towards `-z`.
        to_world: Mat3,
    },
}

impl Environment {
    /// Environment of equal radiance from all directions, sampled in proportion to its power.
    pub fn constant(radiance: Vec3) -> Self {
        Self { kind: EnvironmentKind::Constant { radiance }, sampling_weight: 1.0 }
    }
}

/// Emitter that no ray can hit.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct DeltaEmitter {
    /// Kind and parameters of the emitter.
    pub kind: DeltaKind,
    /// Factor of how often the emitter is sampled, >= 0; at 0 it is dark.
    pub sampling_weight: f32,
}

/// Kinds of emitters that no ray can hit.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum DeltaKind {
    /// `point`: a point light.
    Point {
        /// Position in world space.
        position: Vec3,
        /// Radiant intensity, W/sr.
        intensity: Vec3,
    },
    /// `spot`: a point light with a cone.
    Spot {
        /// Position in world space.
        position: Vec3,
        /// Unit axis of the cone, away from the light.
        direction: Vec3,
        /// Radiant intensity along the axis, W/sr.
        intensity: Vec3,
        /// Half angle of the cone in radians, in (0, pi].
        cutoff_angle: f32,
        /// Half angle in radians within which the intensity is that of the axis. Beyond it, intensity falls linearly
        /// with the angle.
        beam_width: f32,
    },
    /// `spot` with a texture, which the cone throws.
    PicturedSpot {
        /// Position in world space.
        position: Vec3,
        /// Unit axis of the cone, away from the light.
        direction: Vec3,
        /// Directions across the axis along which the picture's `u` and `v` grow.
        axes: PictureAxes,
        /// Radiant intensity along the axis, W/sr, and the texture that multiplies it.
        intensity: Textured<Vec3>,
        /// Half angle of the cone in radians, in (0, pi].
        cutoff_angle: f32,
        /// Half angle in radians up to which the intensity does not fall.
        beam_width: f32,
    },
    /// `projector`: a point light that throws a picture.
    Projector {
        /// Position in world space.
        position: Vec3,
        /// Unit axis, away from the light.
        direction: Vec3,
        /// Directions across the axis along which the picture's `u` and `v` grow.
        axes: PictureAxes,
        /// Irradiance on a screen at distance 1 that faces the light, over pi; W/m^2.
        irradiance: Textured<Vec3>,
    },
    /// `directional`: parallel light from infinitely far away.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// Irradiance on a surface that faces it, W/m^2.
        irradiance: Vec3,
    },
}

/// Directions that place a light's picture. At the offset `d` from the light, the coordinates on the picture are 0.5 +
/// (d.u, d.v) / (d.direction).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PictureAxes {
    /// Direction across the light's axis, over the picture's width at distance 1.
    pub u: Vec3,
    /// Direction across the light's axis, over the picture's height at distance 1.
    pub v: Vec3,
}

impl DeltaKind {
    /// Texture that the light throws.
    pub fn texture(&self) -> Option<u32> {
        match self {
            Self::PicturedSpot { intensity: picture, .. } | Self::Projector { irradiance: picture, .. } => {
                picture.texture
            }
            _ => None,
        }
    }

    /// Position in world space; `None` for a light that is infinitely far away.
    pub fn position(&self) -> Option<Vec3> {
        match *self {
            Self::Point { position, .. }
            | Self::Spot { position, .. }
            | Self::PicturedSpot { position, .. }
            | Self::Projector { position, .. } => Some(position),
            Self::Directional { .. } => None,
        }
    }

    /// Name of the plugin.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Spot { .. } | Self::PicturedSpot { .. } => "spot",
            Self::Projector { .. } => "projector",
            Self::Directional { .. } => "directional",
        }
    }
}
