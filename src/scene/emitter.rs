//! Where light comes from.

use glam::{Mat4, Vec3};

use super::texture::Textured;

/// An `area` emitter: it emits from the side its normal points to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaEmitter {
    /// Emitted radiance in linear sRGB, W/(m^2 sr), each channel >= 0.
    pub radiance: Textured<Vec3>,
}

/// Light from infinitely far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Environment {
    /// `constant`: the same radiance from everywhere.
    Constant {
        /// In linear sRGB, W/(m^2 sr).
        radiance: Vec3,
    },
    /// `envmap`: a latitude-longitude image.
    Map {
        /// Index into `Scene::images`.
        image: u32,
        /// Factor of its radiance.
        scale: f32,
        /// World from the map's space, in which the up axis is `+y`.
        to_world: Mat4,
    },
}

/// An emitter that no ray can hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DeltaEmitter {
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
        /// Half angle of the cone in radians.
        cutoff_angle: f32,
        /// Half angle within which the intensity is that of the axis, radians.
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
