//! The scene as a whole.

use glam::Vec3;

use super::bsdf::Material;
use super::camera::Camera;
use super::deformation::Deformation;
use super::emitter::{AreaEmitter, DeltaEmitter, Environment};
use super::film::FilmDescription;
use super::geometry::{Group, Instance, Primitive};
use super::integrator::IntegratorDescription;
use super::medium::Media;
use super::motion::Motion;
use super::objects::Objects;
use super::texture::{Image, Texture};

/// Whole scene in world space.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Name of the scene: its file's stem, or its folder's name where the stem is `scene`.
    pub name: String,
    /// The camera that the picture is taken with.
    pub camera: Camera,
    /// Names of all cameras of the scene's file in their order; `None` for one without a name.
    pub cameras: Vec<Option<String>>,
    /// The cameras themselves, in this order; `None` for one that cannot be read.
    pub views: Vec<Option<Camera>>,
    /// The sensor's film.
    pub film: FilmDescription,
    /// Settings of the scene file's integrator.
    pub integrator: IntegratorDescription,
    /// `sample_count` of the sensor's sampler.
    pub sample_count: Option<u32>,
    /// Shapes, flattened to world-space primitives, in file order. Copies stand for instances of small groups.
    pub primitives: Vec<Primitive>,
    /// How some of the primitives change their shape while the shutter is open, in the primitives' order.
    pub deformations: Vec<Deformation>,
    /// Groups of primitives that instances show.
    pub groups: Vec<Group>,
    /// Instances of the groups.
    pub instances: Vec<Instance>,
    /// Motions, which instances refer to by index.
    pub motions: Vec<Motion>,
    /// Motion of the camera, whose transform is then that of the middle of the shutter's time.
    pub camera_motion: Option<Motion>,
    /// Names of the objects that primitives and instances belong to.
    pub objects: Objects,
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
    /// Whether the file gives its lights in photometric units, as glTF does. Exporters differ in them by factors of hundreds.
    pub is_photometric: bool,
}

impl Scene {
    /// Axis-aligned box that holds all primitives and instances, as (minimum, maximum); `None` for an empty scene. Without instances
    /// it is the smallest one.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        bounds((&self.primitives, &self.deformations), &self.groups, &self.instances, &self.motions)
    }

    /// Box in the world, at all times, of a box of the group that an instance shows.
    pub(crate) fn placed_box(&self, instance: &Instance, of_group: (Vec3, Vec3)) -> (Vec3, Vec3) {
        placed_box(instance, &self.motions, of_group)
    }

    /// Number of primitives that rays can hit: those of each instance count.
    pub fn shown_primitives(&self) -> u64 {
        let of_instances = self.instances.iter().map(|instance| &self.groups[instance.group as usize].primitives);
        of_instances.fold(self.primitives.len() as u64, |count, primitives| count + primitives.len() as u64)
    }

    /// Number of primitives that are stored.
    pub fn stored_primitives(&self) -> usize {
        self.primitives.len() + self.groups.iter().map(|group| group.primitives.len()).sum::<usize>()
    }
}

/// Box that holds a box of an instance's group at all times.
fn placed_box(instance: &Instance, motions: &[Motion], of_group: (Vec3, Vec3)) -> (Vec3, Vec3) {
    let place = || instance.place_box(of_group);
    let swept = instance
        .motion
        .and_then(|motion| motions[motion as usize].swept(of_group, STEPS).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))));
    let (low, high) = swept.unwrap_or_else(place);
    (low.as_vec3(), high.as_vec3())
}

/// Boxes of each segment of a motion.
const STEPS: u32 = 16;

/// Axis-aligned box that holds all primitives and instances at all times.
pub(super) fn bounds(
    (primitives, deformations): (&[Primitive], &[Deformation]),
    groups: &[Group],
    instances: &[Instance],
    motions: &[Motion],
) -> Option<(Vec3, Vec3)> {
    let union = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
    let of = |primitives: &[Primitive], deformations: &[Deformation]| {
        let deformed = deformations.iter().flat_map(Deformation::boxes).map(|(_, of_key)| of_key);
        primitives.iter().map(Primitive::bounds).chain(deformed).reduce(union)
    };
    let of_groups: Vec<_> = groups.iter().map(|group| of(&group.primitives, &group.deformations)).collect();
    let placed = instances
        .iter()
        .filter_map(|instance| Some(placed_box(instance, motions, of_groups[instance.group as usize]?)));
    of(primitives, deformations).into_iter().chain(placed).reduce(union)
}
