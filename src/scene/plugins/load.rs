//! Reader of descriptions: plugins to a [`Scene`].

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::mem;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DMat4, Mat3, Vec3};
use rayon::prelude::*;

use super::cameras;
use super::emitter_plugin::{self, EnvironmentMapFile, SceneEmitter};
use super::flatten::Common;
use super::instances::{self, Arranged, Item, Placed};
use super::kept_meshes::KeptMeshes;
use super::materials::{Materials, conserve_energy, measured_word_counts};
use super::media::MediumList;
use super::primitives::{self, Made};
use super::projector::Projector;
use super::properties::Properties;
use super::scope::{Scope, Whole};
use super::shape::{self, Geometry, MeshFile, Shape};
use super::sunsky::BakedSky;
use super::texture_images::Decoded;
use super::textures::{Textures, number_images};
use super::triangle_budget::{Promise, TriangleBudget};
use super::{curves, facing, fit, integrator, sensor, texture_images, vertex_colors};
use crate::scene::deformation::MOST_INTERVALS;
use crate::scene::description::Description;
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::{Entry, Object, Value};
use crate::scene::description::origin::{Format, Origin};
use crate::scene::faults::Faults;
use crate::scene::folders::FoundFile;
use crate::scene::load_options::{EnvironmentChoice, LoadOptions};
use crate::scene::mesh::{self, MAX_TRIANGLES, Mesh};
use crate::scene::objects::name_of_id;
use crate::scene::{
    AreaEmitter, DeltaEmitter, Environment, EnvironmentKind, Group, Image, IntegratorDescription, Media, Medium, Scene,
};
use crate::scene::{texel_pages, whole};
use crate::{Error, Result};

/// Callback for the progress of reading a scene.
pub(in crate::scene) type Watch<'a> = dyn Fn(LoadProgress) + Sync + 'a;

/// Progress of reading a scene. Prints as `reading meshes 120/295`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadProgress {
    /// Number of mesh files read so far.
    pub meshes_read: usize,
    /// Number of mesh files that the scene names.
    pub mesh_count: usize,
}

impl fmt::Display for LoadProgress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "reading meshes {}/{}", self.meshes_read, self.mesh_count)
    }
}

/// Scene that is described. Its warnings and faults are taken from the description.
///
/// Only `sample_count` of the sampler is read, because samplers differ in their patterns alone. Parameters that cannot
/// change the picture (such as a film's `file_format`) are skipped in silence; other unknown ones end up in
/// [`Scene::warnings`].
///
/// Meshes of files are taken from `kept` and left there, if it is given.
pub(in crate::scene) fn build(
    description: &mut Description,
    options: &LoadOptions,
    progress: &Watch,
    kept: Option<&KeptMeshes>,
) -> Result<Scene> {
    let (warnings, faults) = (mem::take(&mut description.warnings), mem::take(&mut description.faults));
    let description = &*description;
    let scope = Rc::new(Whole::new(description)?);
    let mut builder = Builder {
        materials: Materials::new(Rc::clone(&scope)),
        media: MediumList::new(Rc::clone(&scope)),
        textures: Textures::new(Rc::clone(&scope)),
        description,
        scope,
        emitters: Vec::new(),
        lit: HashSet::new(),
        environment: None,
        delta_emitters: Vec::new(),
        projectors: Vec::new(),
        images: Vec::new(),
        items: Vec::new(),
        groups: Vec::new(),
        group_indices: HashMap::new(),
        sensors: Vec::new(),
        integrators: Vec::new(),
        loose_emitters: Vec::new(),
        first_moving: None,
        warnings,
        faults,
    };
    for entry in &description.entries {
        let added = builder.add(entry);
        builder.faults.keep(added);
    }
    builder.finish(options, progress, kept)
}

/// Warning about what moves while the shutter is open for no time.
const NO_TIME_TO_MOVE: &str =
    "it does not move, because the shutter is open for no time; give the sensor `shutter_open` and `shutter_close`";

/// Most shapes and instances of a scene.
const MAX_ITEMS: usize = 1 << 24;

/// Scene as far as it has been read.
struct Builder<'a> {
    description: &'a Description,
    scope: Scope<'a>,
    materials: Materials<'a>,
    media: MediumList<'a>,
    textures: Textures<'a>,
    emitters: Vec<AreaEmitter>,
    /// Addresses of the `area` emitters that shapes have.
    lit: HashSet<*const Object>,
    environment: Option<Environment>,
    delta_emitters: Vec<DeltaEmitter>,
    projectors: Vec<Projector>,
    images: Vec<Image>,
    items: Vec<Item<'a>>,
    /// Shapes of each group.
    groups: Vec<Vec<Shape>>,
    /// Index of each group by the address of the `shapegroup`.
    group_indices: HashMap<*const Object, usize>,
    sensors: Vec<&'a Object>,
    integrators: Vec<&'a Object>,
    /// `area` emitters that stand directly in the scene, for shapes to refer to.
    loose_emitters: Vec<&'a Object>,
    /// First shape or instance that moves.
    first_moving: Option<&'a Object>,
    warnings: Vec<String>,
    faults: Faults,
}

impl<'a> Builder<'a> {
    /// Adds what stands directly in the scene.
    fn add(&mut self, entry: &'a Entry) -> Result<()> {
        let origin = || self.description.origin_of(entry);
        let object = match &entry.value {
            Value::Object(object) if object.kind != Kind::Spectrum => object,
            // Other objects refer to it.
            Value::Object(object) if object.id.is_some() => return Ok(()),
            Value::Fault(fault) if fault.of.is_none() => return Err(origin().error(&fault.message)),
            Value::Reference(_) => return Err(origin().error("a reference has no effect here; put it into an object")),
            _ => {
                let message = format!("the parameter `{}` of the scene is unknown; ignored", entry.name);
                self.warnings.push(format!("{}: {message}", origin()));
                return Ok(());
            }
        };
        match object.kind {
            Kind::Integrator => self.integrators.push(object),
            Kind::Sensor => self.sensors.push(object),
            Kind::Emitter => self.add_emitter(object)?,
            Kind::Shape => self.add_shape(object)?,
            // A BSDF that no shape uses is checked too, so that unsupported plugins are reported.
            Kind::Bsdf => self.materials.check(object, &mut self.textures, &mut self.warnings)?,
            Kind::Medium => self.media.check(object, &mut self.warnings)?,
            // They are read where another object refers to them.
            Kind::Texture | Kind::Phase | Kind::Volume => {}
            Kind::Sampler | Kind::Film | Kind::Rfilter => {
                if object.id.is_none() {
                    let [what, scene, sensor] =
                        [object.kind.name(), "scene", "sensor"].map(|name| object.origin.word(name));
                    let message = format!("a {what} in {scene} has no effect; put it into the {sensor}");
                    self.warnings.push(format!("{}: {message}", object.origin));
                }
            }
            kind => {
                let [what, scene] = [kind.name(), "scene"].map(|name| object.origin.word(name));
                let plugin = &object.plugin;
                return Err(object.error(format!("{what} plugin `{plugin}` is not supported in {scene}")));
            }
        }
        Ok(())
    }

    fn add_emitter(&mut self, object: &'a Object) -> Result<()> {
        if object.plugin == "area" {
            self.loose_emitters.push(object);
            return Ok(());
        }
        let read = emitter_plugin::parse(object, &self.scope, &mut self.textures, &mut self.warnings)?;
        let environment = match read {
            SceneEmitter::Delta(emitter) => {
                self.delta_emitters.push(emitter);
                return Ok(());
            }
            SceneEmitter::Projector(projector) => {
                self.projectors.push(projector);
                return Ok(());
            }
            SceneEmitter::Dark => return Ok(()),
            SceneEmitter::Environment(environment) => environment,
            SceneEmitter::Map(file) => self.read_environment_map(object, file)?,
            SceneEmitter::Sky(BakedSky { image, to_world }, sampling_weight) => {
                let kind = EnvironmentKind::Map { image: self.images.len() as u32, scale: 1.0, to_world };
                self.images.push(image);
                Environment { kind, sampling_weight }
            }
        };
        match self.environment.replace(environment) {
            Some(_) => {
                let plugin = &object.plugin;
                Err(object.error(format!("emitter plugin `{plugin}`: a second environment; a scene may have only one")))
            }
            None => Ok(()),
        }
    }

    fn read_environment_map(&mut self, object: &Object, file: EnvironmentMapFile) -> Result<Environment> {
        let EnvironmentMapFile { file, scale, to_world, sampling_weight } = file;
        let (image, notes) = texture_images::decode_environment(&file)?;
        self.warnings.extend(notes.into_iter().map(|note| format!("{}: {note}", object.origin)));
        if !is_large_enough(&image) {
            return Err(object.error("the image of an envmap must have at least 2 x 3 pixels"));
        }
        let kind = EnvironmentKind::Map { image: self.images.len() as u32, scale, to_world };
        self.images.push(image);
        Ok(Environment { kind, sampling_weight })
    }

    /// Replaces the environment by the user's choice.
    fn replace_environment(&mut self, choice: &EnvironmentChoice) -> Result<()> {
        self.images.clear();
        let environment = match choice {
            EnvironmentChoice::Constant => Environment::constant(Vec3::ONE),
            EnvironmentChoice::File(path) => {
                let file = FoundFile { path: path.clone(), bytes: None };
                let (image, notes) = texture_images::decode_environment(&file)?;
                self.warnings.extend(notes.into_iter().map(|note| format!("{}: {note}", path.display())));
                if !is_large_enough(&image) {
                    return Err(Error::image(path, "an environment must have at least 2 x 3 pixels"));
                }
                self.images.push(image);
                let kind = EnvironmentKind::Map { image: 0, scale: 1.0, to_world: Mat3::IDENTITY };
                Environment { kind, sampling_weight: 1.0 }
            }
        };
        self.environment = Some(environment);
        Ok(())
    }

    fn add_shape(&mut self, object: &'a Object) -> Result<()> {
        match &*object.plugin {
            "shapegroup" => self.group(object).map(drop),
            "instance" => self.add_instance(object),
            _ => {
                let shape = self.parse_shape(object)?;
                self.items.extend(shape.map(|shape| Item::Shape(Box::new(shape))));
                Ok(())
            }
        }
    }

    /// Reads a shape; `None` where its geometry, its material or its emitter has a fault.
    fn parse_shape(&mut self, object: &'a Object) -> Result<Option<Shape>> {
        let mut properties = Properties::new(object, &self.scope)?;
        let mut common = Common { material: 0, ..Common::default() };
        let keys = self.faults.keep(properties.take_keys()).flatten();
        let geometry = self.faults.keep(shape::parse_geometry(&mut properties, &mut common));
        let emitter = properties.object(Kind::Emitter)?;
        let boundary = self.media.boundary(&mut properties, &mut self.warnings);
        let boundary = self.faults.keep(boundary).flatten();
        if common.unseen && boundary.is_some() {
            let message =
                "a shape that bounds a medium cannot be invisible to the camera; leave `visible_to_camera` out";
            self.faults.keep::<()>(Err(object.error(message)));
        }
        if common.front_only && boundary.is_some() && geometry.as_ref().and_then(curves::kind).is_none() {
            let message = "a mesh that bounds a medium must be met from both sides; leave `front_only` out";
            self.faults.keep::<()>(Err(object.error(message)));
        }
        let bsdf = properties.object(Kind::Bsdf)?;
        let is_facing = matches!(geometry, Some(Geometry::FacingDisk));
        if is_facing {
            self.faults.keep(facing::check(object, emitter, bsdf, boundary.is_some()));
        }
        let material = match bsdf {
            Some(bsdf) => {
                let shape_id = object.id.as_deref();
                let kept = self.materials.keep(bsdf, shape_id, &mut self.textures, &mut self.warnings);
                self.faults.keep(kept)
            }
            None if is_facing => Some(self.materials.keep_null()),
            None => Some(self.materials.keep_default(emitter.is_some())),
        };
        // Light that crosses a fiber leaves it where it has entered. So the far side must not meet it.
        let has_fibers = material.is_some_and(|material| self.materials.has_fibers(material));
        common.front_only |= has_fibers;
        if has_fibers && boundary.is_some() {
            let message =
                "a shape that bounds a medium cannot have `hair`, which is met from outside only; use another BSDF";
            self.faults.keep::<()>(Err(object.error(message)));
        }
        if let Some(kind) = geometry.as_ref().and_then(curves::kind) {
            self.faults.keep(curves::check_emitter(kind, emitter));
        }
        if let Some(emitter) = emitter {
            self.lit.insert(std::ptr::from_ref(emitter));
            let (scope, textures) = (&self.scope, &mut self.textures);
            // Light leaves on the side of the normal.
            let side = if common.flip_normals { -1.0 } else { 1.0 };
            let axis = side * common.to_world.z_axis.truncate();
            let area = emitter_plugin::parse_area(emitter, axis, scope, textures, &mut self.warnings);
            if let Some(area) = self.faults.keep(area).flatten() {
                if is_facing {
                    self.faults.keep(facing::check_radiance(emitter, &area));
                }
                if keys.is_some() && area.cone.is_some() {
                    return Err(
                        emitter.error("a `spotarea` emitter cannot move; use `area`, or a shape that stands still")
                    );
                }
                common.emitter = Some(self.emitters.len() as u32);
                self.emitters.push(area);
            }
        }
        let (Some(geometry), Some(material)) = (geometry, material) else { return Ok(None) };
        properties.finish(&mut self.warnings)?;
        common.material = match boundary {
            Some(boundary) => self.materials.keep_boundary(material, boundary),
            None => material,
        };
        let name = object_name(object);
        let shape = Shape { geometry, common, name, origin: object.origin.clone(), keys };
        shape.check_keys()?;
        curves::check_keys(&shape)?;
        self.note_motion(shape.keys.is_some(), object);
        Ok(Some(shape))
    }

    /// Index of the shapes of a `shapegroup`, which is not placed in the scene by itself.
    fn group(&mut self, object: &'a Object) -> Result<usize> {
        if let Some(&group) = self.group_indices.get(&std::ptr::from_ref(object)) {
            return Ok(group);
        }
        let mut properties = Properties::new(object, &self.scope)?;
        let members = properties.objects(Kind::Shape);
        properties.finish(&mut self.warnings)?;
        let mut shapes = Vec::new();
        for member in members {
            let member = self.member(member);
            shapes.extend(self.faults.keep(member).flatten());
        }
        let group = self.groups.len();
        self.groups.push(shapes);
        self.group_indices.insert(object, group);
        Ok(group)
    }

    fn member(&mut self, object: &'a Object) -> Result<Option<Shape>> {
        if let plugin @ ("shapegroup" | "instance") = &*object.plugin {
            return Err(object.error(format!("shape plugin `{plugin}` cannot stand inside a `shapegroup`")));
        }
        match self.parse_shape(object)? {
            Some(Shape { common, .. }) if self.has_cone(&common) => {
                Err(object.error("a `spotarea` emitter cannot stand in a `shapegroup`; put its shape into the scene"))
            }
            Some(Shape { keys: Some(_), .. }) => {
                Err(object.error("a shape in a `shapegroup` cannot move; move the `instance` that shows the group"))
            }
            shape => Ok(shape),
        }
    }

    fn has_cone(&self, common: &Common) -> bool {
        common.emitter.is_some_and(|emitter| self.emitters[emitter as usize].cone.is_some())
    }

    /// Remembers the first thing that moves.
    fn note_motion(&mut self, moves: bool, object: &'a Object) {
        if moves {
            self.first_moving.get_or_insert(object);
        }
    }

    fn add_instance(&mut self, object: &'a Object) -> Result<()> {
        let mut properties = Properties::new(object, &self.scope)?;
        let keys = properties.take_keys()?;
        let to_world = properties.take_to_world()?;
        let group = properties.object(Kind::Shape)?.filter(|shape| shape.plugin == "shapegroup");
        let group = group.ok_or_else(|| {
            let reference = object.origin.word("ref");
            object.error(format!("shape plugin `instance` needs a {reference} to a `shapegroup`"))
        })?;
        properties.finish(&mut self.warnings)?;
        let group = self.group(group)?;
        if self.items.len() >= MAX_ITEMS {
            return Err(object.error(format!("more than {MAX_ITEMS} shapes and instances")));
        }
        let check = |key: &DMat4| self.groups[group].iter().try_for_each(|shape| shape.check_instance(key, object));
        check(&to_world)?;
        keys.iter().flat_map(|keys| keys.iter()).try_for_each(|(_, key)| check(key))?;
        self.note_motion(keys.is_some(), object);
        let name = object.id.as_deref().map(|id| Arc::from(name_of_id(id)));
        self.items.push(Item::Instance(Placed { group, to_world, keys, name, origin: &object.origin }));
        Ok(())
    }

    fn integrator(&mut self) -> Result<IntegratorDescription> {
        let Some(object) = self.first(&self.integrators.clone()) else {
            return Ok(IntegratorDescription::default());
        };
        integrator::parse(object, &self.scope, &mut self.warnings)
    }

    /// First of several objects of which one is used; the others get a warning.
    fn first(&mut self, objects: &[&'a Object]) -> Option<&'a Object> {
        for other in objects.iter().skip(1) {
            let word = other.origin.word(other.kind.name());
            self.warnings.push(format!("{}: a second {word}; the first is used", other.origin));
        }
        objects.first().copied()
    }

    fn finish(mut self, options: &LoadOptions, progress: &Watch, kept: Option<&KeptMeshes>) -> Result<Scene> {
        let Description { ref path, format, .. } = *self.description;
        let integrator = self.integrator();
        let integrator = self.faults.keep(integrator).unwrap_or_default();
        if let Some(choice) = &options.environment {
            self.replace_environment(choice)?;
        }
        let sensor =
            cameras::chosen(&self.sensors, options.camera.as_ref(), &self.description.path, &mut self.warnings)?;
        let sensor = sensor.map(|sensor| sensor::parse(sensor, &self.scope, &mut self.media, &mut self.warnings));
        let sensor = sensor.and_then(|sensor| self.faults.keep(sensor));
        let shutter = sensor.as_ref().map_or([0.0; 2], |sensor| sensor.shutter);
        if let (Some(object), true) = (self.first_moving, shutter[0] >= shutter[1]) {
            self.warnings.push(format!("{}: {NO_TIME_TO_MOVE}", object.origin));
        }
        let of_path = self.integrators.first().filter(|integrator| integrator.plugin == "path");
        if let (Some(integrator), false, false) = (of_path, self.media.list.is_empty(), format == Format::Foreign) {
            let message = "Mitsuba's `path` leaves media out; here they are rendered, as by `volpath`";
            self.warnings.push(format!("{}: {message}", integrator.origin));
        }
        for emitter in self.loose_emitters.iter().filter(|&&emitter| !self.lit.contains(&std::ptr::from_ref(emitter))) {
            self.warnings.push(format!("{}: no shape refers to this `area` emitter; it is dark", emitter.origin));
        }
        let mut images = self.images;
        let first_image = images.len();
        let (mut textures, requests) = self.textures.finish();
        let shapes = shown_shapes(&self.items, &self.groups);
        let attributes = vertex_colors::attributes(&textures);
        let of_sets: Vec<String> = (1..=MOST_INTERVALS)
            .flat_map(|at| ["position", "normal"].map(|kind| mesh::set_attribute(kind, at)))
            .collect();
        let attributes: Vec<&str> = attributes.iter().chain(&of_sets).map(String::as_str).collect();
        let (in_memory, files): (Vec<_>, Vec<_>) =
            mesh_files(&shapes).into_iter().partition(|(file, _)| file.index_in_memory().is_some());
        let in_memory = in_memory.into_iter().filter_map(|(file, _)| self.scope.meshes.get(file.index_in_memory()?));
        let budget = TriangleBudget::new(MAX_TRIANGLES, in_memory.map(|mesh| mesh.triangles.len()).sum());
        check_promised(&files, &budget)?;
        let read = |file: &MeshFile| {
            let read = || mesh::read(&file.path, file.format, &attributes);
            kept.map_or_else(|| read().map(Arc::new), |kept| kept.get_or_read(file, &attributes, read))
        };
        let read_meshes = || read_meshes(files, &budget, &read, progress);
        let (decoded, meshes) = rayon::join(|| texture_images::decode(&requests), read_meshes);
        let Decoded { images: decoded, indices, warnings, faults } = decoded;
        let (mut meshes, of_meshes) = meshes;
        kept.iter().for_each(|kept| kept.keep_only(&meshes));
        let given = self.scope.meshes.iter().enumerate();
        meshes.extend(given.map(|(index, mesh)| (MeshFile::in_memory(index), Arc::clone(mesh))));
        faults.into_iter().chain(of_meshes).for_each(|fault| self.faults.add(fault));
        self.faults.into_result()?;
        images.extend(decoded);
        // The image of vertex colors, if a texture uses it, comes after all others.
        number_images(&mut textures, first_image, &indices, images.len());
        self.warnings.extend(warnings);
        let arranged = instances::arrange(self.items, self.groups, &meshes, shutter)?;
        let Arranged { mut shapes, groups, instances, names, motions } = arranged;
        self.warnings.extend(curves::warning(&shapes, &meshes));
        let mut left_out: Vec<_> = meshes.iter().filter_map(|(file, mesh)| mesh::warning(&file.path, mesh)).collect();
        left_out.sort();
        self.warnings.extend(left_out);
        let mut materials = self.materials.finish();
        let image = images.len() as u32;
        let emitters = self.emitters;
        let context = vertex_colors::Context {
            materials: &materials,
            emitters: &emitters,
            textures: &textures,
            meshes: &meshes,
            image,
        };
        let media = self.media.list;
        let measured = measured_word_counts(&materials);
        let has_grids = !media.is_empty() || !measured.is_empty();
        let counts = images.iter().map(texel_pages::word_count).chain(media.iter().flat_map(Medium::word_counts));
        let counts: Vec<u64> = counts.chain(measured).collect();
        if has_grids && texel_pages::place(&counts).is_none() {
            let message =
                "the images, the grids of media and the measured materials fit no device; use fewer or smaller ones";
            return Err(Error::scene(path, None, message));
        }
        if let Some(colors) = vertex_colors::make(&mut shapes, &context, &mut self.warnings)? {
            images.push(colors);
            if texel_pages::place(&images.iter().map(texel_pages::word_count).collect::<Vec<_>>()).is_none() {
                return Err(Error::scene(path, None, "the images and vertex colors fit no device; use smaller images"));
            }
        }
        let mut delta_emitters = self.delta_emitters;
        delta_emitters.extend(self.projectors.into_iter().map(|projector| projector.finish(&textures, &images)));
        conserve_energy(&mut materials, &textures, &images, &mut self.warnings);
        let is_open = shutter[0] < shutter[1];
        if !is_open && self.first_moving.is_none() {
            self.warnings.extend(warning_of_sets(&shapes, &meshes));
        }
        let Made { world: Group { primitives, deformations }, groups, objects } =
            primitives::of_shapes(&shapes, &groups, &names, &meshes, is_open)?;
        let glows = media.iter().any(|medium| medium.emission != Vec3::ZERO);
        let is_dark = !glows && emitters.is_empty() && self.environment.is_none() && delta_emitters.is_empty();
        if is_dark {
            let message = "the scene has no light, so the picture is black; --environment constant lights it evenly";
            self.warnings.push(format!("{}: {message}", path.display()));
        }
        let sensor = match sensor {
            Some(sensor) => sensor,
            None => {
                let bounds = whole::bounds((&primitives, &deformations), &groups, &instances, &motions);
                fit::sensor(path, bounds, format, &mut self.warnings)?
            }
        };
        Ok(Scene {
            name: scene_name(path),
            camera: sensor.camera,
            cameras: self.sensors.iter().map(|sensor| sensor.id.clone()).collect(),
            views: self.sensors.iter().map(|sensor| sensor::parse_camera(sensor, &self.scope).ok()).collect(),
            camera_motion: sensor.motion,
            film: sensor.film,
            integrator,
            sample_count: sensor.sample_count,
            primitives,
            deformations,
            groups,
            instances,
            motions,
            objects,
            materials,
            media: Media { all: media, of_camera: sensor.medium },
            emitters,
            environment: self.environment,
            delta_emitters,
            textures,
            images,
            warnings: self.warnings,
            is_photometric: self.description.is_photometric,
        })
    }
}

/// Name of the object that a shape is a part of: that of its id, or its plugin and place.
fn object_name(shape: &Object) -> Arc<str> {
    match &shape.id {
        Some(id) => name_of_id(id).into(),
        None => format!("{} at {}", shape.plugin, shape.origin.brief()).into(),
    }
}

/// Warning about the first mesh with vertices of several times, for a shutter that is open for no time.
fn warning_of_sets(shapes: &[Shape], meshes: &HashMap<MeshFile, Arc<Mesh>>) -> Option<String> {
    let has_sets = |shape: &&Shape| match &shape.geometry {
        Geometry::Mesh(file, _) => meshes.get(file).is_some_and(|mesh| !mesh.later_sets().is_empty()),
        _ => false,
    };
    let shape = shapes.iter().find(has_sets)?;
    Some(format!("{}: {NO_TIME_TO_MOVE}", shape.origin))
}

/// Whether an image can be an environment.
fn is_large_enough(image: &Image) -> bool {
    image.width >= 2 && image.height >= 3
}

/// Shapes that stand in the scene, and those of the groups that instances show, in the order of the scene.
fn shown_shapes<'s>(items: &'s [Item], groups: &'s [Vec<Shape>]) -> Vec<&'s Shape> {
    let mut is_known = vec![false; groups.len()];
    let shapes = items.iter().flat_map(|item| match item {
        Item::Shape(shape) => std::slice::from_ref(&**shape),
        Item::Instance(placed) if !mem::replace(&mut is_known[placed.group], true) => &groups[placed.group],
        Item::Instance(_) => &[],
    });
    shapes.collect()
}

/// Mesh files of the shapes in the order of the scene, each once, with the first shape that names it.
fn mesh_files<'s>(shapes: &[&'s Shape]) -> Vec<(&'s MeshFile, &'s Origin)> {
    let files = shapes.iter().filter_map(|shape| match &shape.geometry {
        Geometry::Mesh(file, _) => Some((file, &shape.origin)),
        _ => None,
    });
    let mut seen = HashSet::new();
    files.filter(|(file, _)| seen.insert(*file)).collect()
}

/// Refuses files that promise more triangles than the budget has. Those that do not tell their number are left out.
fn check_promised<'s>(files: &[(&'s MeshFile, &'s Origin)], budget: &TriangleBudget) -> Result<()> {
    let promise = |&(file, origin): &(&'s MeshFile, &'s Origin)| {
        let MeshFile { path, format } = file;
        Some(Promise { triangles: mesh::promised_faces(path, *format)?, name: path, origin })
    };
    let promised: Vec<_> = files.par_iter().map(promise).collect();
    budget.check_promised(&promised.into_iter().flatten().collect::<Vec<_>>())
}

/// Reads every mesh once, in parallel, by `read`. Where there are more triangles than the budget has, later meshes are left out. Returns
/// the faults of files in the order of the scene.
fn read_meshes(
    files: Vec<(&MeshFile, &Origin)>,
    budget: &TriangleBudget,
    read: &(dyn Fn(&MeshFile) -> Result<Arc<Mesh>> + Sync),
    progress: &Watch,
) -> (HashMap<MeshFile, Arc<Mesh>>, Vec<Error>) {
    let mut files: Vec<_> = files.into_iter().enumerate().collect();
    // The largest come first, so that none is left over when all else is done.
    files.sort_by_cached_key(|(_, (file, _))| Reverse(file.path.metadata().map_or(0, |metadata| metadata.len())));
    let (mesh_count, read_count) = (files.len(), AtomicUsize::new(0));
    let read = |(place, (file, origin)): (usize, (&MeshFile, &Origin))| {
        if budget.is_spent() {
            return None;
        }
        let mesh = read(file).and_then(|mesh| budget.add(mesh.triangles.len(), &file.path, origin).map(|()| mesh));
        progress(LoadProgress { meshes_read: 1 + read_count.fetch_add(1, Ordering::Relaxed), mesh_count });
        Some((place, mesh.map(|mesh| (file.clone(), mesh))))
    };
    // `par_bridge` hands files out one by one, so this order holds.
    let mut results: Vec<_> = files.into_iter().par_bridge().filter_map(read).collect();
    results.sort_by_key(|(place, _)| *place);
    let (mut meshes, mut faults) = (HashMap::new(), Vec::new());
    for (_, result) in results {
        match result {
            Ok((file, mesh)) => drop(meshes.insert(file, mesh)),
            Err(fault) => faults.push(fault),
        }
    }
    (meshes, faults)
}

/// Name of the scene: the file's stem, or its folder's name where the stem is `scene`.
pub fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder = canonical.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.unwrap_or(stem).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::MeshFormat;

    /// OBJ files do not tell how many triangles they have. The one with which there are too many is the last that is read.
    #[test]
    fn meshes_beyond_the_limit_are_not_read() {
        let origin = Origin::whole(Path::new("scene.xml"), Format::Xml);
        let files: Vec<_> =
            (0..1000).map(|at| MeshFile { path: format!("{at}.obj").into(), format: MeshFormat::Obj }).collect();
        let read_count = AtomicUsize::new(0);
        let read = |_: &MeshFile| {
            read_count.fetch_add(1, Ordering::Relaxed);
            Ok(Arc::new(Mesh { triangles: vec![[0; 3]; 10], ..Mesh::default() }))
        };
        let read_with = |limit| {
            let files = files.iter().map(|file| (file, &origin)).collect();
            read_meshes(files, &TriangleBudget::new(limit, 5), &read, &|_| {})
        };
        let (meshes, faults) = read_with(25);
        // Each thread may have begun one more.
        let most = 3 + rayon::current_num_threads();
        assert!(meshes.len() <= most && read_count.load(Ordering::Relaxed) <= most, "{read_count:?} were read");
        let [fault] = &faults[..] else { panic!("one fault, not {faults:?}") };
        let fault = fault.to_string();
        let sentence = "the scene has 35 triangles so far, after 3 of its mesh files; no more than 25 fit";
        assert!(fault.starts_with("scene.xml: with ") && fault.ends_with(sentence), "{fault}");
        let (meshes, faults) = read_with(10_005);
        assert_eq!((meshes.len(), faults.len()), (1000, 0));
    }
}
