//! Reads a Mitsuba XML scene.

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use super::element::Element;
use super::flatten::Common;
use super::mesh::{self, MAX_TRIANGLES, Mesh};
use super::properties::{Ids, Properties, collect_ids};
use super::shape::{self, Geometry, MeshFile, Shape};
use super::{AreaEmitter, IntegratorDescription, Material, Primitive, Scene};
use super::{document, material, sensor};
use crate::{Error, Result};

/// What the caller overrides while a scene is read.
#[derive(Debug, Clone, Default)]
pub struct LoadOptions {
    /// `-D name=value`: replaces the scene's `<default>` of that name.
    pub defines: Vec<(String, String)>,
}

/// Is told how far the reading of a scene is.
type Watch<'a> = dyn Fn(LoadProgress) + Sync + 'a;

/// How far the reading of a scene is. Prints as `reading meshes 120/295`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadProgress {
    /// Mesh files read so far.
    pub meshes_read: usize,
    /// Mesh files that the scene names.
    pub mesh_count: usize,
}

impl fmt::Display for LoadProgress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "reading meshes {}/{}", self.meshes_read, self.mesh_count)
    }
}

/// [`load_with_progress`] without anyone watching.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    load_with_progress(path, options, &|_| {})
}

/// Reads the scene at `path` with everything it includes. `progress` is called after every mesh, from several threads.
///
/// Of the sampler only `sample_count` is read: plugins differ in their patterns alone. Parameters that cannot change
/// the picture (a film's `file_format`, say) are skipped in silence; other unknown ones end up in [`Scene::warnings`].
pub fn load_with_progress(path: &Path, options: &LoadOptions, progress: &Watch) -> Result<Scene> {
    let elements = document::read(path, &options.defines)?;
    let mut ids = HashMap::new();
    collect_ids(&elements, &mut ids)?;
    let mut builder = Builder {
        ids: Rc::new(ids),
        top_folder: document::folder(path),
        material_indices: HashMap::new(),
        materials: Vec::new(),
        emitters: Vec::new(),
        environment: None,
        shapes: Vec::new(),
        groups: HashMap::new(),
        sensors: Vec::new(),
        integrators: Vec::new(),
        warnings: Vec::new(),
    };
    for element in &elements {
        builder.add(element)?;
    }
    builder.finish(path, progress)
}

/// Shapes of a scene at most. Few instances of a large group can ask for more than any memory holds.
const MAX_SHAPES: usize = 1 << 20;

/// The scene as far as it has been read.
struct Builder<'a> {
    ids: Ids<'a>,
    top_folder: PathBuf,
    /// Keyed by the element's address: each `<bsdf>` is one material, however many shapes refer to it.
    material_indices: HashMap<*const Element, u32>,
    materials: Vec<Material>,
    emitters: Vec<AreaEmitter>,
    environment: Option<Vec3>,
    shapes: Vec<Shape>,
    /// Keyed by the address of the `shapegroup`.
    groups: HashMap<*const Element, Rc<Vec<Shape>>>,
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
            "bsdf" => drop(self.material_index(element, None)?),
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
        match self.environment.replace(radiance) {
            Some(_) => Err(element.error("a second `constant` emitter: a scene has one environment")),
            None => Ok(()),
        }
    }

    fn radiance(&mut self, element: &'a Element) -> Result<Vec3> {
        let mut properties = Properties::new(element, &self.ids)?;
        if let Some(texture) = properties.objects("texture").first() {
            return Err(texture.error("textures are not supported yet; give the `radiance` as <rgb>"));
        }
        let radiance = properties.color("radiance")?.unwrap_or(Vec3::ONE);
        // Light samples are chosen by other means here.
        properties.ignore(&["sampling_weight"]);
        properties.finish(&mut self.warnings)?;
        Ok(radiance)
    }

    fn add_shape(&mut self, element: &'a Element) -> Result<()> {
        match element.plugin()? {
            "shapegroup" => self.group(element).map(drop),
            "instance" => self.add_instance(element),
            _ => {
                let shape = self.parse_shape(element)?;
                self.shapes.push(shape);
                Ok(())
            }
        }
    }

    fn parse_shape(&mut self, element: &'a Element) -> Result<Shape> {
        let mut properties = Properties::new(element, &self.ids)?;
        let mut common = Common { material: 0, ..Common::default() };
        let geometry = shape::parse_geometry(&mut properties, &mut common, &self.top_folder)?;
        common.material = match properties.object("bsdf")? {
            Some(bsdf) => self.material_index(bsdf, element.attribute("id"))?,
            None => self.default_material_index(),
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
        Ok(Shape { geometry, common, location: element.location.clone() })
    }

    /// What stands in a `shapegroup`; by itself it is nowhere in the scene.
    fn group(&mut self, element: &'a Element) -> Result<Rc<Vec<Shape>>> {
        if let Some(group) = self.groups.get(&std::ptr::from_ref(element)) {
            return Ok(group.clone());
        }
        let mut properties = Properties::new(element, &self.ids)?;
        let members = properties.objects("shape");
        properties.finish(&mut self.warnings)?;
        let group: Rc<Vec<_>> = Rc::new(members.into_iter().map(|member| self.member(member)).collect::<Result<_>>()?);
        self.groups.insert(element, group.clone());
        Ok(group)
    }

    fn member(&mut self, element: &'a Element) -> Result<Shape> {
        if let plugin @ ("shapegroup" | "instance") = element.plugin()? {
            return Err(element.error(format!("shape plugin `{plugin}` cannot stand inside a `shapegroup`")));
        }
        let shape = self.parse_shape(element)?;
        match shape.common.emitter {
            Some(_) => Err(element.error("a shape in a `shapegroup` cannot emit; put it into the <scene> itself")),
            None => Ok(shape),
        }
    }

    fn add_instance(&mut self, element: &'a Element) -> Result<()> {
        let mut properties = Properties::new(element, &self.ids)?;
        let to_world = properties.take_to_world()?;
        let group = properties.object("shape")?.filter(|shape| shape.attribute("type") == Some("shapegroup"));
        let group = group.ok_or_else(|| element.error("shape plugin `instance` needs a <ref> to a `shapegroup`"))?;
        properties.finish(&mut self.warnings)?;
        let group = self.group(group)?;
        if self.shapes.len() + group.len() > MAX_SHAPES {
            return Err(element.error(format!("more than {MAX_SHAPES} shapes, those of instances included")));
        }
        let copy = |shape: &Shape| shape.instantiated(to_world, element);
        self.shapes.extend(group.iter().map(copy).collect::<Result<Vec<_>>>()?);
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
        Ok(self.push_material(element, material))
    }

    fn default_material_index(&mut self) -> u32 {
        match self.material_indices.get(&std::ptr::null()) {
            Some(&index) => index,
            None => self.push_material(std::ptr::null(), material::default_material()),
        }
    }

    fn push_material(&mut self, key: *const Element, material: Material) -> u32 {
        let index = self.materials.len() as u32;
        self.materials.push(material);
        self.material_indices.insert(key, index);
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

    fn finish(mut self, path: &Path, progress: &Watch) -> Result<Scene> {
        let integrator = self.integrator()?;
        let sensor = self
            .first("sensor", &self.sensors.clone())
            .ok_or_else(|| Error::scene(path, None, "the scene has no <sensor>; it needs a `perspective` one"))?;
        let sensor = sensor::parse(sensor, &self.ids, &mut self.warnings)?;
        let meshes = read_meshes(&self.shapes, progress)?;
        Ok(Scene {
            name: scene_name(path),
            camera: sensor.camera,
            film: sensor.film,
            integrator,
            sample_count: sensor.sample_count,
            primitives: flatten_all(&self.shapes, &meshes)?,
            materials: self.materials,
            emitters: self.emitters,
            environment: self.environment.unwrap_or(Vec3::ZERO),
            warnings: self.warnings,
        })
    }
}

/// Reads every mesh once, in parallel. Of several faulty files the first in the scene is reported.
fn read_meshes(shapes: &[Shape], progress: &Watch) -> Result<HashMap<MeshFile, Mesh>> {
    let files = shapes.iter().filter_map(|shape| match &shape.geometry {
        Geometry::Mesh(file, _) => Some(file),
        _ => None,
    });
    let mut seen = HashSet::new();
    let mut files: Vec<_> = files.filter(|file| seen.insert(*file)).enumerate().collect();
    // The largest come first, lest one be left over when all else is done.
    files.sort_by_cached_key(|(_, file)| Reverse(file.path.metadata().map_or(0, |metadata| metadata.len())));
    let (mesh_count, read_count) = (files.len(), AtomicUsize::new(0));
    let read = |(place, file): (usize, &MeshFile)| {
        let mesh = mesh::read(&file.path, file.format);
        progress(LoadProgress { meshes_read: 1 + read_count.fetch_add(1, Ordering::Relaxed), mesh_count });
        (place, mesh.map(|mesh| (file.clone(), mesh)))
    };
    // Handed out one by one, so that the order holds.
    let mut results: Vec<_> = files.into_iter().par_bridge().map(read).collect();
    results.sort_by_key(|(place, _)| *place);
    results.into_iter().map(|(_, result)| result).collect()
}

/// All primitives, in the order of the shapes.
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

/// Refuses what no device could hold before any memory is taken for it.
fn check_size(shapes: &[Shape], meshes: &HashMap<MeshFile, Mesh>) -> Result<()> {
    let mut triangles = 0;
    for shape in shapes {
        if let Geometry::Mesh(file, _) = &shape.geometry {
            triangles += meshes.get(file).map_or(0, |mesh| mesh.triangles.len());
        }
        if triangles > MAX_TRIANGLES {
            let message =
                format!("with this shape the scene has {triangles} triangles; no more than {MAX_TRIANGLES} fit");
            return Err(shape.location.error(message));
        }
    }
    Ok(())
}

/// The file's stem, or its folder's name where that says more.
fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder = canonical.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.unwrap_or(stem).to_string_lossy().into_owned()
}
