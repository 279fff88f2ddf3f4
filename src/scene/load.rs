//! Reads a Mitsuba XML scene.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::DMat4;
use rayon::prelude::*;

use super::element::Element;
use super::emitter_plugin::{self, EnvironmentMapFile, SceneEmitter};
use super::flatten::Common;
use super::mesh::{self, Mesh};
use super::properties::{Ids, Properties, collect_ids};
use super::shape::{self, Geometry, Shape};
use super::texture::{Image, Texels};
use super::{
    AreaEmitter, DeltaEmitter, Environment, EnvironmentKind, IntegratorDescription, Material, Primitive, Scene,
};
use super::{document, material, sensor};
use crate::image::exr::read_rgb;
use crate::{Error, Result};

/// What the caller overrides while a scene is read.
#[derive(Debug, Clone, Default)]
pub struct LoadOptions {
    /// `-D name=value`: replaces the scene's `<default>` of that name.
    pub defines: Vec<(String, String)>,
}

/// Reads the scene at `path` with everything it includes.
///
/// Of the sampler only `sample_count` is read: plugins differ in their patterns alone. Parameters that cannot change
/// the picture (a film's `file_format`, say) are skipped in silence; other unknown ones end up in [`Scene::warnings`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let elements = document::read(path, &options.defines)?;
    let mut ids = HashMap::new();
    collect_ids(&elements, &mut ids)?;
    let mut builder = Builder {
        ids: Rc::new(ids),
        top_folder: document::folder(path),
        material_indices: HashMap::new(),
        materials: Vec::new(),
        default_materials: [None; 2],
        emitters: Vec::new(),
        environment: None,
        delta_emitters: Vec::new(),
        images: Vec::new(),
        shapes: Vec::new(),
        sensors: Vec::new(),
        integrators: Vec::new(),
        warnings: Vec::new(),
    };
    for element in &elements {
        builder.add(element)?;
    }
    builder.finish(path)
}

/// The scene as far as it has been read.
struct Builder<'a> {
    ids: Ids<'a>,
    top_folder: PathBuf,
    /// Keyed by the element's address: each `<bsdf>` is one material, however many shapes refer to it.
    material_indices: HashMap<*const Element, u32>,
    materials: Vec<Material>,
    /// Of shapes without a BSDF: those that do not emit, and those that do.
    default_materials: [Option<u32>; 2],
    emitters: Vec<AreaEmitter>,
    environment: Option<Environment>,
    delta_emitters: Vec<DeltaEmitter>,
    images: Vec<Image>,
    shapes: Vec<Shape>,
    sensors: Vec<&'a Element>,
    integrators: Vec<&'a Element>,
    warnings: Vec<String>,
}

impl<'a> Builder<'a> {
    /// Takes in an element that stands directly in `<scene>`.
    fn add(&mut self, element: &'a Element) -> Result<()> {
        match element.tag.as_str() {
            "integrator" => self.integrators.push(element),
            "sensor" => self.sensors.push(element),
            "emitter" => self.add_emitter(element)?,
            "shape" => self.add_shape(element)?,
            // Also where no shape uses it: a plugin that is not supported should not pass unseen.
            "bsdf" => drop(self.material_index(element, None)?),
            // Does nothing by itself; what refers to it reports it.
            "texture" => {}
            tag => return Err(element.error(format!("<{tag}> is not supported in <scene>"))),
        }
        Ok(())
    }

    fn add_emitter(&mut self, element: &'a Element) -> Result<()> {
        let environment = match emitter_plugin::parse(element, &self.ids, &self.top_folder, &mut self.warnings)? {
            SceneEmitter::Delta(emitter) => {
                self.delta_emitters.push(emitter);
                return Ok(());
            }
            SceneEmitter::Environment(environment) => environment,
            SceneEmitter::Map(file) => self.read_environment_map(element, file)?,
        };
        match self.environment.replace(environment) {
            Some(_) => {
                let plugin = element.plugin()?;
                Err(element.error(format!("emitter plugin `{plugin}`: a second environment; a scene has one")))
            }
            None => Ok(()),
        }
    }

    fn read_environment_map(&mut self, element: &Element, file: EnvironmentMapFile) -> Result<Environment> {
        let picture = read_rgb(&file.path)?;
        if picture.width < 2 || picture.height < 3 {
            return Err(element.error("the image of an envmap must have at least 2 x 3 pixels"));
        }
        let color = |pixel: &[f32; 3]| pixel.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 });
        let texels = picture.pixels.iter().map(color).map(|[r, g, b]| [r, g, b, 1.0]).collect();
        let (width, height) = (picture.width, picture.height);
        let EnvironmentMapFile { path, scale, to_world, sampling_weight } = file;
        let kind = EnvironmentKind::Map { image: self.images.len() as u32, scale, to_world };
        self.images.push(Image { name: path.display().to_string(), width, height, texels: Texels::Floats(texels) });
        Ok(Environment { kind, sampling_weight })
    }

    fn add_shape(&mut self, element: &'a Element) -> Result<()> {
        let mut properties = Properties::new(element, &self.ids)?;
        let mut common = Common { to_world: DMat4::IDENTITY, flip_normals: false, material: 0, emitter: None };
        let geometry = shape::parse_geometry(&mut properties, &mut common, &self.top_folder)?;
        let emitter = properties.object("emitter")?;
        common.material = match properties.object("bsdf")? {
            Some(bsdf) => self.material_index(bsdf, element.attribute("id"))?,
            None => self.default_material_index(emitter.is_some()),
        };
        if let Some(emitter) = emitter {
            common.emitter = Some(self.emitters.len() as u32);
            self.emitters.push(emitter_plugin::parse_area(emitter, &self.ids, &mut self.warnings)?);
        }
        properties.finish(&mut self.warnings)?;
        self.shapes.push(Shape { geometry, common, location: element.location.clone() });
        Ok(())
    }

    fn material_index(&mut self, element: &'a Element, shape_id: Option<&str>) -> Result<u32> {
        if let Some(&index) = self.material_indices.get(&std::ptr::from_ref(element)) {
            return Ok(index);
        }
        let name = match element.attribute("id").or(shape_id) {
            Some(id) => id.to_string(),
            None => format!("{} at line {}", element.plugin()?, element.location.line),
        };
        let material = material::parse(element, name, &self.ids, &mut self.warnings)?;
        let index = self.materials.len() as u32;
        self.materials.push(material);
        self.material_indices.insert(element, index);
        Ok(index)
    }

    /// What a shape without a BSDF is made of: as in Mitsuba, black where it emits.
    fn default_material_index(&mut self, emits: bool) -> u32 {
        if let Some(index) = self.default_materials[usize::from(emits)] {
            return index;
        }
        let index = self.materials.len() as u32;
        self.materials.push(if emits { material::emitter_material() } else { material::default_material() });
        self.default_materials[usize::from(emits)] = Some(index);
        index
    }

    fn integrator(&mut self) -> Result<IntegratorDescription> {
        let Some(element) = self.first("integrator", &self.integrators.clone()) else {
            return Ok(IntegratorDescription::default());
        };
        let mut properties = Properties::new(element, &self.ids)?;
        if properties.plugin() != "path" {
            return Err(element.unsupported(&["path"]));
        }
        let depth = |depth: Option<i64>| depth.map(|depth| depth as i32);
        let description = IntegratorDescription {
            max_depth: depth(properties.integer("max_depth", -1..=i32::MAX as i64)?),
            rr_depth: depth(properties.integer("rr_depth", 1..=i32::MAX as i64)?),
            hide_emitters: properties.boolean("hide_emitters")?.unwrap_or(false),
        };
        properties.finish(&mut self.warnings)?;
        Ok(description)
    }

    /// The first of several elements of which one is used, with a warning for the others.
    fn first(&mut self, what: &str, elements: &[&'a Element]) -> Option<&'a Element> {
        for other in elements.iter().skip(1) {
            self.warnings.push(format!("{}: a second <{what}>; the first is used", other.location));
        }
        elements.first().copied()
    }

    fn finish(mut self, path: &Path) -> Result<Scene> {
        let integrator = self.integrator()?;
        let sensor = self
            .first("sensor", &self.sensors.clone())
            .ok_or_else(|| Error::scene(path, None, "the scene has no <sensor>; it needs a `perspective` one"))?;
        let sensor = sensor::parse(sensor, &self.ids, &mut self.warnings)?;
        let meshes = read_meshes(&self.shapes)?;
        Ok(Scene {
            name: scene_name(path),
            camera: sensor.camera,
            film: sensor.film,
            integrator,
            sample_count: sensor.sample_count,
            primitives: flatten_all(&self.shapes, &meshes)?,
            materials: self.materials,
            emitters: self.emitters,
            environment: self.environment,
            delta_emitters: self.delta_emitters,
            textures: Vec::new(),
            images: self.images,
            warnings: self.warnings,
        })
    }
}

/// Reads every mesh file once, in parallel. Of several faulty files the first in the scene is reported.
fn read_meshes(shapes: &[Shape]) -> Result<HashMap<PathBuf, Mesh>> {
    let mut paths: Vec<&Path> = Vec::new();
    let mut seen = std::collections::HashSet::new();
    for shape in shapes {
        if let Geometry::Mesh(path, _) = &shape.geometry
            && seen.insert(path)
        {
            paths.push(path);
        }
    }
    let results: Vec<_> = paths.par_iter().map(|path| Ok((path.to_path_buf(), mesh::read(path)?))).collect();
    results.into_iter().collect()
}

fn flatten_all(shapes: &[Shape], meshes: &HashMap<PathBuf, Mesh>) -> Result<Vec<Primitive>> {
    let results: Vec<_> = shapes.par_iter().map(|shape| shape::flatten(shape, meshes)).collect();
    let primitives: Vec<_> = results.into_iter().collect::<Result<_>>()?;
    Ok(primitives.concat())
}

/// The file's stem, or its folder's name where that says more.
fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder = canonical.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.unwrap_or(stem).to_string_lossy().into_owned()
}
