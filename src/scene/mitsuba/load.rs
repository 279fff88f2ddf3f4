//! Reader of Mitsuba's XML scenes.

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use super::document::Document;
use super::element::{Element, PARAMETER_TAGS};
use super::emitter_plugin::{self, EnvironmentMapFile, SceneEmitter};
use super::faults::Faults;
use super::fit::View;
use super::flatten::Common;
use super::folders::FoundFile;
use super::materials::{Materials, conserve_energy};
use super::projector::Projector;
use super::properties::Properties;
use super::scope::{Scope, Whole};
use super::shape::{self, Geometry, MeshFile, Shape};
use super::sunsky::BakedSky;
use super::texture_images::Decoded;
use super::textures::Textures;
use super::{curves, cylinder, document, fit, integrator, old_files, sensor, texture_images, vertex_colors};
use crate::scene::load_options::{CameraChoice, EnvironmentChoice, LoadOptions};
use crate::scene::mesh::{self, MAX_TRIANGLES, Mesh};
use crate::scene::texel_pages;
use crate::scene::{
    AreaEmitter, DeltaEmitter, Environment, EnvironmentKind, Image, IntegratorDescription, Primitive, Scene,
};
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

/// Reads the scene at `path`, a file in XML, with everything it includes.
///
/// Only `sample_count` of the sampler is read, because samplers differ in their patterns alone. Parameters that cannot
/// change the picture (such as a film's `file_format`) are skipped in silence; other unknown ones end up in
/// [`Scene::warnings`].
pub(in crate::scene) fn read(path: &Path, options: &LoadOptions, progress: &Watch) -> Result<Scene> {
    build(document::read(path, &options.defines)?, path, options, progress)
}

/// Builds the scene of a document that was read from `path`, or whose entries begin with that name.
pub(super) fn build(document: Document, path: &Path, options: &LoadOptions, progress: &Watch) -> Result<Scene> {
    let Document { elements, folders, meshes, mut warnings, faults, view } = document;
    warnings.extend(old_files::warning(&elements));
    let scope = Rc::new(Whole::new(&elements, folders, meshes.len())?);
    let mut builder = Builder {
        materials: Materials::new(Rc::clone(&scope)),
        textures: Textures::new(Rc::clone(&scope)),
        scope,
        emitters: Vec::new(),
        lit: HashSet::new(),
        environment: None,
        delta_emitters: Vec::new(),
        projectors: Vec::new(),
        images: Vec::new(),
        shapes: Vec::new(),
        groups: HashMap::new(),
        sensors: Vec::new(),
        integrators: Vec::new(),
        loose_emitters: Vec::new(),
        warnings,
        faults,
    };
    for element in &elements {
        let added = builder.add(element);
        builder.faults.keep(added);
    }
    builder.finish(path, meshes, view, options, progress)
}

/// Most shapes of a scene. A few instances of a large group can ask for more than any memory holds.
const MAX_SHAPES: usize = 1 << 20;

/// Scene as far as it has been read.
struct Builder<'a> {
    scope: Scope<'a>,
    materials: Materials<'a>,
    textures: Textures<'a>,
    emitters: Vec<AreaEmitter>,
    /// Addresses of the `area` emitters that shapes have.
    lit: HashSet<*const Element>,
    environment: Option<Environment>,
    delta_emitters: Vec<DeltaEmitter>,
    projectors: Vec<Projector>,
    images: Vec<Image>,
    shapes: Vec<Shape>,
    /// Shapes of each group, by the address of the `shapegroup`.
    groups: HashMap<*const Element, Rc<Vec<Shape>>>,
    sensors: Vec<&'a Element>,
    integrators: Vec<&'a Element>,
    /// `area` emitters that stand in `<scene>`, for shapes to refer to.
    loose_emitters: Vec<&'a Element>,
    warnings: Vec<String>,
    faults: Faults,
}

impl<'a> Builder<'a> {
    /// Adds an element that stands directly in `<scene>`.
    fn add(&mut self, element: &'a Element) -> Result<()> {
        match element.tag.as_str() {
            "integrator" => self.integrators.push(element),
            "sensor" => self.sensors.push(element),
            "emitter" => self.add_emitter(element)?,
            "shape" => self.add_shape(element)?,
            // A `<bsdf>` that no shape uses is checked too, so that unsupported plugins are reported.
            "bsdf" => self.materials.check(element, &mut self.textures, &mut self.warnings)?,
            // These are read where another element refers to them.
            "texture" | "alias" => {}
            "sampler" | "film" | "rfilter" => {
                if element.attribute("id").is_none() {
                    let message = format!("a <{}> in <scene> has no effect; put it into the <sensor>", element.tag);
                    self.warnings.push(format!("{}: {message}", element.location));
                }
            }
            tag if PARAMETER_TAGS.contains(&tag) => {
                let name = element.attribute("name").unwrap_or_default();
                let message = format!("the parameter `{name}` of the scene is unknown; ignored");
                self.warnings.push(format!("{}: {message}", element.location));
            }
            tag => {
                let plugin = element.attribute("type").unwrap_or_default();
                return Err(element.error(format!("<{tag}> plugin `{plugin}` is not supported in <scene>")));
            }
        }
        Ok(())
    }

    fn add_emitter(&mut self, element: &'a Element) -> Result<()> {
        if element.attribute("type") == Some("area") {
            self.loose_emitters.push(element);
            return Ok(());
        }
        let read = emitter_plugin::parse(element, &self.scope, &mut self.textures, &mut self.warnings)?;
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
            SceneEmitter::Map(file) => self.read_environment_map(element, file)?,
            SceneEmitter::Sky(BakedSky { image, to_world }, sampling_weight) => {
                let kind = EnvironmentKind::Map { image: self.images.len() as u32, scale: 1.0, to_world };
                self.images.push(image);
                Environment { kind, sampling_weight }
            }
        };
        match self.environment.replace(environment) {
            Some(_) => {
                let plugin = element.plugin()?;
                Err(element
                    .error(format!("emitter plugin `{plugin}`: a second environment; a scene may have only one")))
            }
            None => Ok(()),
        }
    }

    fn read_environment_map(&mut self, element: &Element, file: EnvironmentMapFile) -> Result<Environment> {
        let EnvironmentMapFile { file, scale, to_world, sampling_weight } = file;
        let (image, notes) = texture_images::decode_environment(&file)?;
        self.warnings.extend(notes.into_iter().map(|note| format!("{}: {note}", element.location)));
        if !is_large_enough(&image) {
            return Err(element.error("the image of an envmap must have at least 2 x 3 pixels"));
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

    fn add_shape(&mut self, element: &'a Element) -> Result<()> {
        match element.plugin()? {
            "shapegroup" => self.group(element).map(drop),
            "instance" => self.add_instance(element),
            _ => {
                let shape = self.parse_shape(element)?;
                self.shapes.extend(shape);
                Ok(())
            }
        }
    }

    /// Reads a shape; `None` where its geometry, its material or its emitter has a fault.
    fn parse_shape(&mut self, element: &'a Element) -> Result<Option<Shape>> {
        let mut properties = Properties::new(element, &self.scope)?;
        let mut common = Common { material: 0, ..Common::default() };
        let geometry = self.faults.keep(shape::parse_geometry(&mut properties, &mut common));
        let emitter = properties.object("emitter")?;
        let material = match properties.object("bsdf")? {
            Some(bsdf) => {
                let shape_id = element.attribute("id");
                let kept = self.materials.keep(bsdf, shape_id, &mut self.textures, &mut self.warnings);
                self.faults.keep(kept)
            }
            None => Some(self.materials.keep_default(emitter.is_some())),
        };
        if let Some(kind) = geometry.as_ref().and_then(curves::kind) {
            self.faults.keep(curves::check_emitter(kind, emitter));
        }
        if let Some(emitter) = emitter {
            self.lit.insert(std::ptr::from_ref(emitter));
            let (scope, textures) = (&self.scope, &mut self.textures);
            let area = emitter_plugin::parse_area(emitter, scope, textures, &mut self.warnings);
            if let Some(area) = self.faults.keep(area).flatten() {
                common.emitter = Some(self.emitters.len() as u32);
                self.emitters.push(area);
            }
        }
        let (Some(geometry), Some(material)) = (geometry, material) else { return Ok(None) };
        properties.finish(&mut self.warnings)?;
        common.material = material;
        Ok(Some(Shape { geometry, common, location: element.location.clone() }))
    }

    /// Shapes of a `shapegroup`, which is not placed in the scene by itself.
    fn group(&mut self, element: &'a Element) -> Result<Rc<Vec<Shape>>> {
        if let Some(group) = self.groups.get(&std::ptr::from_ref(element)) {
            return Ok(group.clone());
        }
        let mut properties = Properties::new(element, &self.scope)?;
        let members = properties.objects("shape");
        properties.finish(&mut self.warnings)?;
        let mut shapes = Vec::new();
        for member in members {
            let member = self.member(member);
            shapes.extend(self.faults.keep(member).flatten());
        }
        let group = Rc::new(shapes);
        self.groups.insert(element, group.clone());
        Ok(group)
    }

    fn member(&mut self, element: &'a Element) -> Result<Option<Shape>> {
        if let plugin @ ("shapegroup" | "instance") = element.plugin()? {
            return Err(element.error(format!("shape plugin `{plugin}` cannot stand inside a `shapegroup`")));
        }
        let shape = self.parse_shape(element)?;
        match shape.as_ref().and_then(|shape| shape.common.emitter) {
            Some(_) => Err(element.error("a shape in a `shapegroup` cannot emit; put it into the <scene> itself")),
            None => Ok(shape),
        }
    }

    fn add_instance(&mut self, element: &'a Element) -> Result<()> {
        let mut properties = Properties::new(element, &self.scope)?;
        let to_world = properties.take_to_world()?;
        let group = properties.object("shape")?.filter(|shape| shape.attribute("type") == Some("shapegroup"));
        let group = group.ok_or_else(|| element.error("shape plugin `instance` needs a <ref> to a `shapegroup`"))?;
        properties.finish(&mut self.warnings)?;
        let group = self.group(group)?;
        if self.shapes.len() + group.len() > MAX_SHAPES {
            return Err(element.error(format!("more than {MAX_SHAPES} shapes, including the shapes of instances")));
        }
        let copy = |shape: &Shape| shape.instantiated(to_world, element);
        self.shapes.extend(group.iter().map(copy).collect::<Result<Vec<_>>>()?);
        Ok(())
    }

    fn integrator(&mut self) -> Result<IntegratorDescription> {
        let Some(element) = self.first("integrator", &self.integrators.clone()) else {
            return Ok(IntegratorDescription::default());
        };
        integrator::parse(element, &self.scope, &mut self.warnings)
    }

    /// First of several elements of which one is used; the others get a warning.
    fn first(&mut self, what: &str, elements: &[&'a Element]) -> Option<&'a Element> {
        for other in elements.iter().skip(1) {
            self.warnings.push(format!("{}: a second <{what}>; the first is used", other.location));
        }
        elements.first().copied()
    }

    /// Sensor that the user has chosen, or else the first; `None` for a fitted one.
    fn chosen_sensor(&mut self, path: &Path, choice: Option<&CameraChoice>) -> Result<Option<&'a Element>> {
        let sensors = self.sensors.clone();
        let name = match choice {
            None => return Ok(self.first("sensor", &sensors)),
            Some(CameraChoice::Fit) => return Ok(None),
            Some(CameraChoice::Named(name)) => name,
        };
        let named = sensors.iter().find(|sensor| sensor.attribute("id") == Some(name));
        let found = named.or_else(|| sensors.get(name.parse::<usize>().ok()?));
        found.copied().map(Some).ok_or_else(|| {
            let of = |(index, sensor): (usize, &&Element)| match sensor.attribute("id") {
                Some(id) => format!("{index} (`{id}`)"),
                None => index.to_string(),
            };
            let known = sensors.iter().enumerate().map(of).collect::<Vec<_>>().join(", ");
            let list = if known.is_empty() { "none".to_owned() } else { known };
            Error::scene(
                path,
                None,
                format!("there is no camera `{name}`; the scene's cameras are: {list}; or use `fit`"),
            )
        })
    }

    fn finish(
        mut self,
        path: &Path,
        given: Vec<Mesh>,
        view: View,
        options: &LoadOptions,
        progress: &Watch,
    ) -> Result<Scene> {
        let integrator = self.integrator();
        let integrator = self.faults.keep(integrator).unwrap_or_default();
        if let Some(choice) = &options.environment {
            self.replace_environment(choice)?;
        }
        let sensor = self.chosen_sensor(path, options.camera.as_ref())?;
        let sensor = sensor.map(|sensor| sensor::parse(sensor, &self.scope, &mut self.warnings));
        let sensor = sensor.and_then(|sensor| self.faults.keep(sensor));
        for emitter in self.loose_emitters.iter().filter(|&&emitter| !self.lit.contains(&std::ptr::from_ref(emitter))) {
            self.warnings.push(format!("{}: no shape refers to this `area` emitter; it is dark", emitter.location));
        }
        let mut images = self.images;
        let (textures, requests) = self.textures.finish(images.len() as u32);
        let shapes = &self.shapes;
        let (decoded, meshes) = rayon::join(|| texture_images::decode(&requests), || read_meshes(shapes, progress));
        let Decoded { images: decoded, warnings, faults } = decoded;
        let (mut meshes, of_meshes) = meshes;
        meshes.extend(given.into_iter().enumerate().map(|(index, mesh)| (MeshFile::in_memory(index), mesh)));
        faults.into_iter().chain(of_meshes).for_each(|fault| self.faults.add(fault));
        self.faults.into_result()?;
        images.extend(decoded);
        self.warnings.extend(warnings);
        self.warnings.extend(curves::warning(&self.shapes, &meshes));
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
        if let Some(colors) = vertex_colors::make(&mut self.shapes, &context, &mut self.warnings)? {
            images.push(colors);
            if texel_pages::place(&images.iter().map(texel_pages::word_count).collect::<Vec<_>>()).is_none() {
                return Err(Error::scene(path, None, "the images and vertex colors fit no device; use smaller images"));
            }
        }
        let mut delta_emitters = self.delta_emitters;
        delta_emitters.extend(self.projectors.into_iter().map(|projector| projector.finish(&textures, &images)));
        conserve_energy(&mut materials, &textures, &images, &mut self.warnings);
        let primitives = flatten_all(&self.shapes, &meshes)?;
        let is_dark = emitters.is_empty() && self.environment.is_none() && delta_emitters.is_empty();
        if is_dark && view == View::Front {
            let message = "the scene has no light; --environment constant lights it evenly";
            self.warnings.push(format!("{}: {message}", path.display()));
        }
        let sensor = match sensor {
            Some(sensor) => sensor,
            None => fit::sensor(path, &primitives, view, &mut self.warnings)?,
        };
        Ok(Scene {
            name: scene_name(path),
            camera: sensor.camera,
            film: sensor.film,
            integrator,
            sample_count: sensor.sample_count,
            primitives,
            materials,
            emitters,
            environment: self.environment,
            delta_emitters,
            textures,
            images,
            warnings: self.warnings,
        })
    }
}

/// Whether an image can be an environment.
fn is_large_enough(image: &Image) -> bool {
    image.width >= 2 && image.height >= 3
}

/// Reads every mesh once, in parallel. Returns the faults of files in the order of the scene.
fn read_meshes(shapes: &[Shape], progress: &Watch) -> (HashMap<MeshFile, Mesh>, Vec<Error>) {
    let files = shapes.iter().filter_map(|shape| match &shape.geometry {
        Geometry::Mesh(file, _) if !file.is_in_memory() => Some(file),
        _ => None,
    });
    let mut seen = HashSet::new();
    let mut files: Vec<_> = files.filter(|file| seen.insert(*file)).enumerate().collect();
    // The largest come first, so that none is left over when all else is done.
    files.sort_by_cached_key(|(_, file)| Reverse(file.path.metadata().map_or(0, |metadata| metadata.len())));
    let (mesh_count, read_count) = (files.len(), AtomicUsize::new(0));
    let read = |(place, file): (usize, &MeshFile)| {
        let mesh = mesh::read(&file.path, file.format);
        progress(LoadProgress { meshes_read: 1 + read_count.fetch_add(1, Ordering::Relaxed), mesh_count });
        (place, mesh.map(|mesh| (file.clone(), mesh)))
    };
    // `par_bridge` hands files out one by one, so this order holds.
    let mut results: Vec<_> = files.into_iter().par_bridge().map(read).collect();
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

/// Makes all primitives, in the order of the shapes.
fn flatten_all(shapes: &[Shape], meshes: &HashMap<MeshFile, Mesh>) -> Result<Vec<Primitive>> {
    check_size(shapes, meshes)?;
    let placed: Vec<_> = shapes.par_iter().map(|shape| shape::place(shape, meshes)).collect();
    let placed: Vec<_> = placed.into_iter().collect::<Result<_>>()?;
    let mut ends = Vec::with_capacity(placed.len());
    let mut count = 0;
    for shape in &placed {
        count += shape.len();
        ends.push(count);
    }
    let primitive = |index: usize| {
        let shape = ends.partition_point(|&end| end <= index);
        placed[shape].primitive(index + placed[shape].len() - ends[shape])
    };
    Ok((0..count).into_par_iter().map(primitive).collect())
}

/// Refuses scenes larger than any device could hold, before memory is allocated.
fn check_size(shapes: &[Shape], meshes: &HashMap<MeshFile, Mesh>) -> Result<()> {
    let mut triangles = 0;
    for shape in shapes {
        triangles += match &shape.geometry {
            Geometry::Mesh(file, _) => meshes.get(file).map_or(0, |mesh| mesh.triangles.len()),
            Geometry::Cylinder => cylinder::UNIT.triangles.len(),
            _ => 0,
        };
        if triangles > MAX_TRIANGLES {
            let message =
                format!("with this shape the scene has {triangles} triangles; no more than {MAX_TRIANGLES} fit");
            return Err(shape.location.error(message));
        }
    }
    Ok(())
}

/// Name of the scene: the file's stem, or its folder's name where the stem is `scene`.
fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder = canonical.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.unwrap_or(stem).to_string_lossy().into_owned()
}
