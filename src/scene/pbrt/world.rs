//! Scene as its directives give it: no names are followed yet.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::DMat4;

use super::color_space::ColorSpace;
use super::form::Form;
use super::parameters::Parameters;
use super::tokens::Place;
use super::transforms::Current;
use crate::scene::description::make::{animation, matrix};
use crate::scene::description::object::Value;
use crate::scene::mesh::Strand;

/// Directive with its type, its parameters and what held where it stands.
#[derive(Debug, Clone)]
pub(super) struct Entity {
    /// Type, such as `perspective` of a camera.
    pub kind: String,
    pub parameters: Parameters,
    pub to_world: Current,
    /// Transform at the end of the motion, where it is another.
    pub at_end: Option<Current>,
    pub color_space: ColorSpace,
}

impl Entity {
    pub fn error(&self, message: impl Into<String>) -> crate::Error {
        self.parameters.error(message)
    }
}

/// Names of the media inside and outside of surfaces; an empty name is empty space.
pub(super) type Sides = Rc<[String; 2]>;

/// Material that a shape uses.
#[derive(Debug, Clone)]
pub(super) enum MaterialUse {
    /// pbrt's default: a gray diffuse surface.
    Default,
    /// Material of a directive `Material`.
    Unnamed(Rc<Entity>),
    /// Material of a directive `MakeNamedMaterial`.
    Named(String, Place),
}

/// Shape with what held where it stands.
#[derive(Debug)]
pub(super) struct Shape {
    pub form: Form,
    /// Tubes, which take the place of the form.
    pub tubes: Vec<Strand>,
    /// The directive; its parameters hold no more than the form leaves over.
    pub entity: Entity,
    pub is_reversed: bool,
    pub material: MaterialUse,
    pub light: Option<Rc<Entity>>,
    pub media: Sides,
}

impl Shape {
    /// Whether both shapes are tubes that differ in nothing else.
    pub fn has_alike_tubes(&self, other: &Self) -> bool {
        let place = |shape: &Self| (shape.entity.to_world.matrix, shape.entity.at_end.map(|end| end.matrix));
        let is_plain =
            |shape: &Self| !shape.tubes.is_empty() && !shape.entity.parameters.has("alpha") && shape.light.is_none();
        let has_one_material = match (&self.material, &other.material) {
            (MaterialUse::Default, MaterialUse::Default) => true,
            (MaterialUse::Unnamed(one), MaterialUse::Unnamed(other)) => Rc::ptr_eq(one, other),
            (MaterialUse::Named(one, _), MaterialUse::Named(other, _)) => one == other,
            _ => false,
        };
        let is_turned = self.is_reversed != other.is_reversed;
        is_plain(self)
            && is_plain(other)
            && has_one_material
            && !is_turned
            && place(self) == place(other)
            && self.media == other.media
    }
}

/// Shapes that instances copy.
#[derive(Debug)]
pub(super) struct Object {
    pub name: String,
    pub place: Place,
    pub shapes: Vec<Shape>,
}

/// Copy of an object.
#[derive(Debug)]
pub(super) struct Instance {
    pub name: String,
    pub place: Place,
    pub to_world: Current,
    /// Transform at the end of the motion, where it is another.
    pub at_end: Option<Current>,
}

/// Texture with the number of its directive: a texture may use only earlier ones.
#[derive(Debug)]
pub(super) struct NamedTexture {
    pub entity: Entity,
    pub number: usize,
}

/// Whole scene as its directives give it.
#[derive(Debug, Default)]
pub(super) struct World {
    /// Times of the two transforms of what moves; 0 and 1 where the file gives none.
    pub times: Option<[f64; 2]>,
    /// Whether anything moves.
    pub moves: bool,
    pub camera: Option<Entity>,
    pub film: Option<Entity>,
    /// Whether the film is one of pbrt-v3, whose filter is a box where none is given.
    pub has_old_film: bool,
    pub filter: Option<Entity>,
    pub sampler: Option<Entity>,
    pub integrator: Option<Entity>,
    pub shapes: Vec<Shape>,
    pub objects: Vec<Object>,
    pub instances: Vec<Instance>,
    pub lights: Vec<Entity>,
    pub materials: HashMap<String, Rc<Entity>>,
    pub media: HashMap<String, Entity>,
    /// Media that surfaces border or that the camera is in, each with the place of its first use.
    pub used_media: BTreeMap<String, Place>,
    /// Media inside and outside of surfaces where the camera stands. The camera is outside.
    pub camera_media: Sides,
    /// Textures that give a number.
    pub numbers: HashMap<String, NamedTexture>,
    /// Textures that give a color.
    pub colors: HashMap<String, NamedTexture>,
}

impl World {
    /// Value of a transform: of one matrix, or of two at the times of the motion.
    pub fn placed(&self, start: &DMat4, end: Option<&DMat4>) -> Value {
        let [first, last] = self.times.unwrap_or([0.0, 1.0]);
        match end {
            Some(end) => animation(&[(first, *start), (last, *end)]),
            None => matrix(start),
        }
    }
}
