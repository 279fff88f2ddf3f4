//! The scene as a whole.

use glam::Vec3;

use super::bsdf::Material;
use super::camera::Camera;
use super::emitter::{AreaEmitter, DeltaEmitter, Environment};
use super::film::FilmDescription;
use super::geometry::Primitive;
use super::integrator::IntegratorDescription;
use super::medium::Media;
use super::texture::{Image, Texture};

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
    /// Media, which the boundaries of materials refer to by index.
    pub media: Media,
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
