//! Reads a Mitsuba XML scene.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::{DMat4, Vec3};
use rayon::prelude::*;

use super::element::Element;
use super::flatten::Common;
use super::materials::Materials;
use super::mesh::{self, Mesh};
use super::properties::{Ids, Properties, collect_ids};
use super::shape::{self, Geometry, Shape};
use super::textures::{Role, Textures};
use super::{AreaEmitter, Environment, IntegratorDescription, Primitive, Scene, Textured};
use super::{document, sensor, texture_images};
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
    let (ids, top_folder) = (Rc::new(ids), document::folder(path));
    let mut builder = Builder {
        materials: Materials::new(Rc::clone(&ids)),
        textures: Textures::new(Rc::clone(&ids), top_folder.clone()),
        ids,
        top_folder,
        emitters: Vec::new(),
        environment: None,
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
    materials: Materials<'a>,
    textures: Textures<'a>,
    emitters: Vec<AreaEmitter>,
    environment: Option<Vec3>,
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
            "emitter" => self.add_environment(element)?,
            "shape" => self.add_shape(element)?,
            // Also where no shape uses it: a plugin that is not supported should not pass unseen.
            "bsdf" => self.materials.check(element, &mut self.textures, &mut self.warnings)?,
            // Does nothing by itself; what refers to it reports it.
            "texture" => {}
            tag => return Err(element.error(format!("<{tag}> is not supported in <scene>"))),
        }
        Ok(())
    }

    fn add_environment(&mut self, element: &'a Element) -> Result<()> {
        if element.plugin()? != "constant" {
            let supported = ["constant", "area"];
            return Err(match element.attribute("type") {
                Some("area") => element.error("emitter plugin `area` belongs inside a <shape>"),
                _ => element.unsupported(&supported),
            });
        }
        let radiance = self.radiance(element)?;
        if radiance.texture.is_some() {
            return Err(element.error("the `radiance` of a `constant` emitter must be a color, not a texture"));
        }
        match self.environment.replace(radiance.value) {
            Some(_) => Err(element.error("a second `constant` emitter: a scene has one environment")),
            None => Ok(()),
        }
    }

    fn radiance(&mut self, element: &'a Element) -> Result<Textured<Vec3>> {
        let mut properties = Properties::new(element, &self.ids)?;
        let radiance = match properties.texture("radiance")? {
            Some(texture) => {
                let found = self.textures.read(texture, Role::Radiance, &mut self.warnings)?;
                Textured { value: found.factor, texture: Some(self.textures.keep(found.texture)) }
            }
            None => Textured::constant(properties.emission("radiance")?.unwrap_or(Vec3::ONE)),
        };
        // Light samples are chosen by other means here.
        properties.ignore(&["sampling_weight"]);
        properties.finish(&mut self.warnings)?;
        Ok(radiance)
    }

    fn add_shape(&mut self, element: &'a Element) -> Result<()> {
        let mut properties = Properties::new(element, &self.ids)?;
        let mut common = Common { to_world: DMat4::IDENTITY, flip_normals: false, material: 0, emitter: None };
        let geometry = shape::parse_geometry(&mut properties, &mut common, &self.top_folder)?;
        common.material = match properties.object("bsdf")? {
            Some(bsdf) => {
                let shape_id = element.attribute("id");
                self.materials.keep(bsdf, shape_id, &mut self.textures, &mut self.warnings)?
            }
            None => self.materials.keep_default(),
        };
        if let Some(emitter) = properties.object("emitter")? {
            if emitter.plugin()? != "area" {
                return Err(emitter.unsupported(&["area"]));
            }
            let radiance = self.radiance(emitter)?;
            common.emitter = Some(self.emitters.len() as u32);
            self.emitters.push(AreaEmitter { radiance });
        }
        properties.finish(&mut self.warnings)?;
        self.shapes.push(Shape { geometry, common, location: element.location.clone() });
        Ok(())
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
        let (textures, requests) = self.textures.finish();
        let images = texture_images::decode(requests, &mut self.warnings)?;
        let meshes = read_meshes(&self.shapes)?;
        Ok(Scene {
            name: scene_name(path),
            camera: sensor.camera,
            film: sensor.film,
            integrator,
            sample_count: sensor.sample_count,
            primitives: flatten_all(&self.shapes, &meshes)?,
            materials: self.materials.finish(),
            emitters: self.emitters,
            environment: self.environment.map(|radiance| Environment::Constant { radiance }),
            delta_emitters: Vec::new(),
            textures,
            images,
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
