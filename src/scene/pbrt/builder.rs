//! Graphics state of pbrt, and the scene that grows by each directive.

use std::collections::{HashMap, HashSet};
use std::mem;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::color_space::ColorSpace;
use super::curves::{self, Curve};
use super::files::Files;
use super::form::{Form, too_many_triangles};
use super::old_files;
use super::parameters::{MAX_PARAMETERS, Parameter, Parameters};
use super::read_form;
use super::tokens::{Place, brief};
use super::transforms::Current;
use super::world::{Entity, Instance, MaterialUse, NamedTexture, Object, Shape, Sides, World};
use crate::Result;
use crate::scene::faults::Faults;
use crate::scene::mesh::{MAX_TRIANGLES, Mesh};

/// Deepest nesting of `AttributeBegin`.
const MAX_DEPTH: usize = 1024;
/// Most shapes, lights, materials and textures of a scene.
const MAX_ENTITIES: usize = 1 << 20;
/// Most instances of a scene.
const MAX_INSTANCES: usize = 1 << 24;

/// Targets of the directive `Attribute`.
const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// Graphics state: what holds for the directives that follow.
#[derive(Debug, Clone)]
pub(super) struct State {
    /// Transforms at the start and at the end of the motion.
    pub to_world: [Current; 2],
    pub is_reversed: bool,
    /// Which of the two transforms directives change.
    pub is_active: [bool; 2],
    color_space: ColorSpace,
    material: MaterialUse,
    light: Option<Rc<Entity>>,
    /// Media inside and outside of surfaces.
    media: Sides,
    /// Parameters by `Attribute`, for each of [`TARGETS`].
    attributes: [Rc<Vec<Rc<Parameter>>>; TARGETS.len()],
}

/// Scene that grows by each directive.
pub(super) struct Builder {
    pub files: Files,
    pub state: State,
    pub faults: Faults,
    pub warnings: Vec<String>,
    pub world: World,
    /// Files being read, from the main one.
    pub open_files: Vec<Arc<Path>>,
    pub include_count: usize,
    pushed: Vec<State>,
    /// The object whose shapes are being read, and the number of states that were pushed before it.
    object: Option<(Object, usize)>,
    object_names: HashSet<String>,
    coordinate_systems: HashMap<String, [Current; 2]>,
    is_world: bool,
    /// Warnings that were given.
    known_warnings: HashSet<&'static str>,
    texture_count: usize,
    entity_count: usize,
    vertex_count: usize,
    /// Triangles of the forms in memory, at most [`MAX_TRIANGLES`].
    triangle_count: usize,
}

impl Builder {
    /// Builder of the scene whose main file is at `main`.
    pub fn new(main: &Path) -> Self {
        let state = State {
            to_world: [Current::IDENTITY; 2],
            is_reversed: false,
            is_active: [true; 2],
            color_space: ColorSpace::Srgb,
            material: MaterialUse::Default,
            light: None,
            media: Sides::default(),
            attributes: Default::default(),
        };
        Self {
            files: Files::new(main),
            state,
            faults: Faults::default(),
            warnings: Vec::new(),
            world: World::default(),
            open_files: Vec::new(),
            include_count: 0,
            pushed: Vec::new(),
            object: None,
            object_names: HashSet::new(),
            coordinate_systems: HashMap::new(),
            is_world: false,
            known_warnings: HashSet::new(),
            texture_count: 0,
            entity_count: 0,
            vertex_count: 0,
            triangle_count: 0,
        }
    }

    /// Whether the description of the world has begun.
    pub fn has_world(&self) -> bool {
        self.is_world
    }

    /// Place of a block that was begun, but not ended.
    pub fn open_block(&self) -> Option<&Place> {
        self.object.as_ref().map(|(object, _)| &object.place)
    }

    /// Warns of a kind of thing, once for the whole scene.
    pub fn warn_once(&mut self, place: &Place, message: &'static str) {
        if self.known_warnings.insert(message) {
            self.warnings.push(format!("{place}: {message}"));
        }
    }

    pub fn begin_world(&mut self, place: &Place) -> Result<()> {
        if mem::replace(&mut self.is_world, true) {
            return Err(place.error("a second WorldBegin; a file describes one scene"));
        }
        self.state.to_world = [Current::IDENTITY; 2];
        self.state.is_active = [true; 2];
        self.coordinate_systems.insert("world".to_owned(), [Current::IDENTITY; 2]);
        Ok(())
    }

    pub fn push(&mut self, place: &Place) -> Result<()> {
        if self.pushed.len() >= MAX_DEPTH {
            return Err(place.error(format!("AttributeBegin is nested more than {MAX_DEPTH} deep")));
        }
        self.pushed.push(self.state.clone());
        Ok(())
    }

    pub fn pop(&mut self, place: &Place) -> Result<()> {
        let floor = self.object.as_ref().map_or(0, |(_, count)| *count);
        if self.pushed.len() <= floor {
            return Err(place.error("AttributeEnd without an AttributeBegin before it"));
        }
        self.state = self.pushed.pop().unwrap_or_else(|| self.state.clone());
        Ok(())
    }

    pub fn begin_object(&mut self, name: &str, place: &Place) -> Result<()> {
        self.check_world("ObjectBegin", place)?;
        self.push(place)?;
        if self.object.is_some() {
            return Err(place.error("ObjectBegin inside another one; end the first with ObjectEnd"));
        }
        if !self.object_names.insert(name.to_owned()) {
            return Err(place.error(format!("a second object `{}`; give it another name", brief(name))));
        }
        self.count(place)?;
        let object = Object { name: name.to_owned(), place: place.clone(), shapes: Vec::new() };
        self.object = Some((object, self.pushed.len()));
        Ok(())
    }

    pub fn end_object(&mut self, place: &Place) -> Result<()> {
        let Some((object, count)) = self.object.take() else {
            return Err(place.error("ObjectEnd without an ObjectBegin before it"));
        };
        if self.pushed.len() != count {
            return Err(place.error("ObjectEnd before the AttributeEnd of a block within the object"));
        }
        self.world.objects.push(object);
        self.pop(place)
    }

    pub fn add_instance(&mut self, name: &str, place: &Place) -> Result<()> {
        self.check_world("ObjectInstance", place)?;
        if self.object.is_some() {
            return Err(place.error("ObjectInstance inside an object is not part of pbrt; put it after ObjectEnd"));
        }
        if self.world.instances.len() >= MAX_INSTANCES {
            return Err(place.error(format!("more than {MAX_INSTANCES} instances")));
        }
        let (to_world, at_end) = self.transforms();
        self.world.moves |= at_end.is_some();
        self.world.instances.push(Instance { name: name.to_owned(), place: place.clone(), to_world, at_end });
        Ok(())
    }

    pub fn use_named_material(&mut self, name: &str, place: &Place) {
        self.state.material = MaterialUse::Named(name.to_owned(), place.clone());
    }

    /// Changes a directive of pbrt-v3 into one of v4.
    fn upgrade(&mut self, directive: &str, kind: &mut String, parameters: &mut Parameters) -> Result<()> {
        let is_image = directive == "Film" && kind == "image";
        let is_known = self.known_warnings.contains(old_files::WARNING);
        if old_files::upgrade(directive, kind, parameters, is_known)? {
            self.warn_once(&parameters.place, old_files::WARNING);
        }
        self.world.has_old_film |= is_image;
        Ok(())
    }

    /// Defines a medium. One that no surface borders changes no picture.
    pub fn add_medium(&mut self, name: String, mut parameters: Parameters) -> Result<()> {
        let place = parameters.place.clone();
        self.count(&place)?;
        self.upgrade("MakeNamedMedium", &mut String::new(), &mut parameters)?;
        let parameters = parameters.with_defaults(&self.state.attributes[3]);
        let kind = parameters.text("type")?.unwrap_or_default().to_owned();
        let medium = self.entity(kind, parameters);
        match self.world.media.insert(name.clone(), medium) {
            Some(_) => Err(place.error(format!("a second medium `{}`; give it another name", brief(&name)))),
            None => Ok(()),
        }
    }

    pub fn set_media(&mut self, sides: [String; 2], place: &Place) {
        for name in sides.iter().filter(|name| !name.is_empty()) {
            self.world.used_media.entry(name.clone()).or_insert_with(|| place.clone());
        }
        self.state.media = Rc::new(sides);
    }

    pub fn set_color_space(&mut self, name: &str, place: &Place) -> Result<()> {
        self.state.color_space = ColorSpace::named(name).map_err(|message| place.error(message))?;
        Ok(())
    }

    pub fn set_transform(&mut self, transform: Current, place: &Place) -> Result<()> {
        self.set_transforms([transform; 2], place)
    }

    /// Sets those of the two transforms that are active.
    fn set_transforms(&mut self, transforms: [Current; 2], place: &Place) -> Result<()> {
        let State { to_world, is_active, .. } = &mut self.state;
        for ((own, transform), _) in to_world.iter_mut().zip(transforms).zip(is_active).filter(|(_, active)| **active) {
            *own = transform;
        }
        match to_world.iter().all(Current::is_finite) {
            true => Ok(()),
            false => Err(place.error("the current transform leaves the range of single-precision numbers")),
        }
    }

    pub fn transform_by(&mut self, by: &Current, place: &Place) -> Result<()> {
        self.set_transforms(self.state.to_world.map(|own| own.after(by)), place)
    }

    /// Sets the times of the two transforms.
    pub fn set_times(&mut self, times: [f64; 2], place: &Place) -> Result<()> {
        self.check_options("TransformTimes", place)?;
        match times[0] < times[1] {
            true => self.world.times = Some(times),
            false => return Err(place.error("TransformTimes: the second time must be after the first")),
        }
        Ok(())
    }

    /// The transform at the start of the motion, and that at its end where it is another.
    fn transforms(&self) -> (Current, Option<Current>) {
        let [start, end] = self.state.to_world;
        (start, Some(end).filter(|end| end.matrix != start.matrix))
    }

    /// Tells that something stands where it is at the start of the motion, if the transform changes.
    fn warn_if_moving(&mut self, place: &Place, message: &'static str) {
        if self.transforms().1.is_some() {
            self.warn_once(place, message);
        }
    }

    pub fn keep_coordinate_system(&mut self, name: &str) {
        self.coordinate_systems.insert(name.to_owned(), self.state.to_world);
    }

    pub fn use_coordinate_system(&mut self, name: &str, place: &Place) -> Result<()> {
        let Some(&transform) = self.coordinate_systems.get(name) else {
            return Err(place.error(format!(
                "there is no coordinate system `{}`; name it by CoordinateSystem before",
                brief(name)
            )));
        };
        self.set_transforms(transform, place)
    }

    pub fn set_attributes(&mut self, target: &str, parameters: Parameters) -> Result<()> {
        let Some(index) = TARGETS.iter().position(|known| *known == target) else {
            return Err(parameters.error(format!(
                "`{}` has no attributes; use one of {}",
                brief(target),
                TARGETS.join(", ")
            )));
        };
        let (old, place) = (mem::take(&mut self.state.attributes[index]), parameters.place.clone());
        let mut list = parameters.into_list();
        list.extend(old.iter().filter(|old| !list.iter().any(|new| new.name == old.name)).cloned().collect::<Vec<_>>());
        if list.len() > MAX_PARAMETERS {
            return Err(
                place.error(format!("the attributes of `{target}` are more than {MAX_PARAMETERS}; leave some out"))
            );
        }
        self.state.attributes[index] = Rc::new(list);
        Ok(())
    }

    pub fn add_texture(
        &mut self,
        name: String,
        value: &str,
        mut kind: String,
        mut parameters: Parameters,
    ) -> Result<()> {
        let place = parameters.place.clone();
        self.check_world("Texture", &place)?;
        self.count(&place)?;
        self.upgrade("Texture", &mut kind, &mut parameters)?;
        let entity = self.entity(kind, parameters.with_defaults(&self.state.attributes[4]));
        let (number, textures) = (self.texture_count, &mut self.world);
        self.texture_count += 1;
        let textures = match value {
            "float" => &mut textures.numbers,
            // pbrt-v3 says `color`.
            "spectrum" | "color" => &mut textures.colors,
            other => return Err(place.error(format!("a texture gives `float` or `spectrum`, not `{}`", brief(other)))),
        };
        match textures.contains_key(&name) {
            true => Err(place.error(format!("a second texture `{}`; give it another name", brief(&name)))),
            false => {
                textures.insert(name, NamedTexture { entity, number });
                Ok(())
            }
        }
    }

    /// Adds what a directive with a type and parameters describes.
    pub fn add(&mut self, directive: &str, mut kind: String, mut parameters: Parameters) -> Result<()> {
        let place = parameters.place.clone();
        self.count(&place)?;
        self.upgrade(directive, &mut kind, &mut parameters)?;
        match directive {
            "Camera" => {
                self.check_options(directive, &place)?;
                let world_from_camera = self.state.to_world.map(|own| own.inverted());
                self.coordinate_systems.insert("camera".to_owned(), world_from_camera);
                let camera = self.entity(kind, parameters);
                self.world.moves |= camera.at_end.is_some();
                self.world.camera = Some(camera);
                self.world.camera_media = Rc::clone(&self.state.media);
            }
            "Film" | "PixelFilter" | "Sampler" | "Integrator" => {
                self.check_options(directive, &place)?;
                let entity = Some(self.entity(kind, parameters));
                match directive {
                    "Film" => self.world.film = entity,
                    "PixelFilter" => self.world.filter = entity,
                    "Sampler" => self.world.sampler = entity,
                    _ => self.world.integrator = entity,
                }
            }
            "Accelerator" => {}
            "Shape" => self.add_shape(kind, parameters)?,
            "LightSource" => {
                self.check_world(directive, &place)?;
                self.warn_if_moving(
                    &place,
                    "lights without a shape do not move, as in pbrt; they stand where they are at the start",
                );
                let light = self.entity(kind, parameters.with_defaults(&self.state.attributes[1]));
                self.world.lights.push(light);
            }
            "AreaLightSource" => {
                self.check_world(directive, &place)?;
                let light = self.entity(kind, parameters.with_defaults(&self.state.attributes[1]));
                self.state.light = Some(Rc::new(light));
            }
            "Material" => {
                let material = self.entity(kind, parameters.with_defaults(&self.state.attributes[2]));
                self.state.material = MaterialUse::Unnamed(Rc::new(material));
            }
            _ => {
                let type_of = parameters.text("type")?;
                let type_of =
                    type_of.ok_or_else(|| place.error("MakeNamedMaterial needs its parameter \"string type\""))?;
                let type_of = type_of.to_owned();
                let material = self.entity(type_of, parameters.with_defaults(&self.state.attributes[2]));
                if self.world.materials.insert(kind.clone(), Rc::new(material)).is_some() {
                    return Err(place.error(format!("a second material `{}`; give it another name", brief(&kind))));
                }
            }
        }
        Ok(())
    }

    fn add_shape(&mut self, kind: String, parameters: Parameters) -> Result<()> {
        self.check_world("Shape", &parameters.place)?;
        let mut entity = self.entity(kind, parameters.with_defaults(&self.state.attributes[0]));
        if self.object.is_some() && entity.at_end.is_some() {
            return Err(entity.error("a shape that moves inside an object is not supported; move its ObjectInstance"));
        }
        self.world.moves |= entity.at_end.is_some();
        let room = MAX_TRIANGLES - self.triangle_count;
        let mut tubes = Vec::new();
        let form = match entity.kind.as_str() {
            "curve" => {
                entity.parameters.ignore(&["alpha"]);
                curves::read(&entity).map(|curve| match curve {
                    Curve::Strip(mesh) => Form::Mesh(mesh),
                    Curve::Tubes(of_curve) => {
                        tubes = vec![of_curve];
                        Form::Mesh(Mesh::default())
                    }
                })
            }
            _ => read_form::read(&entity, room, &mut self.files, &mut self.warnings),
        };
        let Some(form) = self.faults.keep(form) else { return Ok(()) };
        if form.triangle_count() > room {
            return Err(entity.error(too_many_triangles(self.triangle_count + form.triangle_count())));
        }
        self.triangle_count += form.triangle_count();
        self.vertex_count += form.vertex_count() + tubes.iter().flatten().map(Vec::len).sum::<usize>();
        if self.vertex_count > 3 * MAX_TRIANGLES {
            let most = 3 * MAX_TRIANGLES;
            return Err(
                entity.error(format!("with this shape the scene has more than {most} vertices; leave out unused ones"))
            );
        }
        self.warnings.extend(entity.parameters.unread());
        entity.parameters.keep_only(&["alpha"]);
        let State { is_reversed, ref material, ref light, ref media, .. } = self.state;
        let (material, light, media) = (material.clone(), light.clone(), Rc::clone(media));
        let mut shape = Shape { form, tubes, entity, is_reversed, material, light, media };
        if self.object.is_some() && shape.light.take().is_some() {
            self.warn_once(&shape.entity.parameters.place, "shapes of objects do not emit, as in pbrt");
        }
        let shapes = match &mut self.object {
            Some((object, _)) => &mut object.shapes,
            None => &mut self.world.shapes,
        };
        // Hair has many curves, each a directive of its own.
        match shapes.last_mut().filter(|last| last.has_alike_tubes(&shape)) {
            Some(last) => {
                last.tubes.append(&mut shape.tubes);
                self.entity_count -= 1;
            }
            None => shapes.push(shape),
        }
        Ok(())
    }

    /// State before an import, which inherits the state but does not change it.
    pub fn begin_import(&mut self, place: &Place) -> Result<(State, usize)> {
        self.check_world("Import", place)?;
        Ok((self.state.clone(), self.pushed.len()))
    }

    pub fn end_import(&mut self, (state, depth): (State, usize), place: &Place) -> Result<()> {
        if self.pushed.len() != depth {
            return Err(place.error("the imported file does not end each block that it begins"));
        }
        self.state = state;
        Ok(())
    }

    fn entity(&self, kind: String, parameters: Parameters) -> Entity {
        let (to_world, at_end) = self.transforms();
        Entity { kind, parameters, to_world, at_end, color_space: self.state.color_space }
    }

    fn count(&mut self, place: &Place) -> Result<()> {
        self.entity_count += 1;
        match self.entity_count > MAX_ENTITIES {
            true => Err(place.error(format!("more than {MAX_ENTITIES} shapes, lights, materials and textures"))),
            false => Ok(()),
        }
    }

    fn check_world(&self, directive: &str, place: &Place) -> Result<()> {
        match self.is_world {
            true => Ok(()),
            false => Err(place.error(format!("{directive} must stand after WorldBegin"))),
        }
    }

    fn check_options(&self, directive: &str, place: &Place) -> Result<()> {
        match self.is_world {
            true => Err(place.error(format!("{directive} must stand before WorldBegin"))),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tokens::Tokens;
    use super::*;

    /// A shape beyond the limit ends the reading where it stands. A subdivision beyond it is not even made.
    #[test]
    fn triangles_are_counted_while_shapes_are_read() {
        let mut builder = Builder::new(Path::new("a.pbrt"));
        (builder.is_world, builder.triangle_count) = (true, MAX_TRIANGLES - 5);
        let mut add = |kind: &str, parameters: &str| {
            let file: Arc<Path> = Arc::from(Path::new("a.pbrt"));
            let mut tokens = Tokens::new(parameters, Arc::clone(&file));
            let parameters = Parameters::read(&mut tokens, Place { file, line: 1 }, "Shape".to_owned())?;
            builder.add("Shape", kind.to_owned(), parameters)
        };
        let triangle = "\"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]";
        add("loopsubdiv", &format!("{triangle} \"integer levels\" 1")).unwrap();
        add("loopsubdiv", &format!("{triangle} \"integer levels\" 2")).unwrap();
        add("trianglemesh", triangle).unwrap();
        let error = add("cylinder", "").unwrap_err().to_string();
        let (sentence, limit) = ("a.pbrt:1: with this shape the scene has 335", "so far; no more than 33554432 fit");
        assert!(error.starts_with(sentence) && error.contains(" triangles ") && error.ends_with(limit), "{error}");
        assert_eq!((builder.world.shapes.len(), builder.triangle_count), (2, MAX_TRIANGLES));
        let fault = builder.faults.into_result().unwrap_err().to_string();
        let sentence =
            "with 2 levels the scene has 33554447 triangles so far, but no more than 33554432 fit; use fewer";
        assert_eq!(fault, format!("a.pbrt:1: `loopsubdiv`: {sentence}"));
    }
}
