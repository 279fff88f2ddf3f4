//! Where light comes from.

use glam::{Mat3, Vec3};

use super::texture::Textured;

/// An `area` emitter: it emits from the side its normal points to.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct AreaEmitter {
    /// Emitted radiance in linear sRGB, W/(m^2 sr), each channel >= 0.
    pub radiance: Textured<Vec3>,
    /// Factor of how often the emitter is sampled, >= 0; at 0 only rays that meet it by chance see it.
    pub sampling_weight: f32,
}

impl AreaEmitter {
    /// That is sampled as its power asks for.
    pub fn new(radiance: Textured<Vec3>) -> Self {
        Self { radiance, sampling_weight: 1.0 }
    }
}

/// Light from infinitely far away.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Environment {
    /// How it is spread over the directions.
    pub kind: EnvironmentKind,
    /// Factor of how often it is sampled, >= 0.
    pub sampling_weight: f32,
}

/// How an environment's light is spread over the directions.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum EnvironmentKind {
    /// `constant`: the same radiance from everywhere.
    Constant {
        /// In linear sRGB, W/(m^2 sr), each channel >= 0.
        radiance: Vec3,
    },
    /// `envmap`: a latitude-longitude image.
    Map {
        /// Index into `Scene::images`; at least 2 x 3 texels.
        image: u32,
        /// Factor of its radiance, >= 0.
        scale: f32,
        /// World from the map's space, in which the up axis is `+y` and the map's center `-z`: orthogonal.
        to_world: Mat3,
    },
}

impl Environment {
    /// The same radiance from everywhere, sampled as its power asks for.
    pub fn constant(radiance: Vec3) -> Self {
        Self { kind: EnvironmentKind::Constant { radiance }, sampling_weight: 1.0 }
    }
}

/// An emitter that no ray can hit.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct DeltaEmitter {
    /// Where its light comes from.
    pub kind: DeltaKind,
    /// Factor of how often the emitter is sampled, >= 0; at 0 it is dark.
    pub sampling_weight: f32,
}

/// Where the light of an emitter that no ray can hit comes from.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum DeltaKind {
    /// `point`
    Point {
        /// World space.
        position: Vec3,
        /// Radiant intensity, W/sr.
        intensity: Vec3,
    },
    /// `spot`
    Spot {
        /// World space.
        position: Vec3,
        /// Unit axis of the cone, away from the light.
        direction: Vec3,
        /// Radiant intensity along the axis, W/sr.
        intensity: Vec3,
        /// Half angle of the cone in radians, in (0, pi].
        cutoff_angle: f32,
        /// Half angle within which the intensity is that of the axis, radians; beyond it falls linearly with the angle.
        beam_width: f32,
    },
    /// `directional`
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// Irradiance on a surface that faces it, W/m^2.
        irradiance: Vec3,
    },
}

impl DeltaKind {
    /// The plugin's name.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Spot { .. } => "spot",
            Self::Directional { .. } => "directional",
        }
    }
}
