//! Conversion of BSDFs to [`Material`]s.

mod film;
mod hair;
mod ior;
mod lobes;
mod measured;
mod mixture;
mod named_conductors;
mod parameters;
mod principled;
mod surfaces;
mod tree;

use std::collections::{HashMap, HashSet};
use std::ptr;

use glam::Vec3;

use super::properties::Properties;
use super::role::Role;
use super::scope::Scope;
use super::textures::Textures;
use crate::Result;
use crate::generated::constants;
use crate::scene::bsdf::{Bsdf, Coating, Material, MaterialKind, Relief, ReliefRules, Sheen, SurfaceMaterial};
use crate::scene::description::kinds::Kind;
use crate::scene::description::object::Object;
use crate::scene::faults::{self, Faults};
use crate::scene::medium::Boundary;
use crate::scene::texture::Textured;
pub(super) use lobes::conserve_energy;
use measured::MeasuredFiles;
pub(super) use measured::word_counts as measured_word_counts;
use parameters::{DEFAULT_REFLECTANCE, Parameters};
use tree::{Tree, null_surface};

/// Plugins that contain other BSDFs.
const MODIFIERS: [&str; 8] =
    ["twosided", "mask", "blendbsdf", "mixturebsdf", "bumpmap", "normalmap", "coating", "sheen"];

/// Elements that act on the polarization of light, with the share of unpolarized light that they transmit.
const POLARIZING: [(&str, f32); 3] = [("polarizer", 0.5), ("circular", 0.5), ("retarder", 1.0)];

/// Most textures of a material, which is the number of links in its record.
const MAX_TEXTURES: usize = constants::TEXTURE_LINKS as usize;
/// Most surfaces of a material. Nested blends of the same few materials may multiply.
const MAX_SURFACES: usize = 64;
/// Deepest nesting of choices that the kernels follow.
const MAX_CHOICES: usize = constants::MAX_CHOICES as usize;
/// Deepest nesting of BSDFs, references included.
const MAX_DEPTH: usize = 64;

/// Whether a plugin is a BSDF that this reader knows.
pub(super) fn is_known(plugin: &str) -> bool {
    let is_polarizing = POLARIZING.iter().any(|(name, _)| *name == plugin);
    plugin == "null"
        || is_polarizing
        || MODIFIERS.contains(&plugin)
        || surfaces::READERS.iter().any(|(name, _)| *name == plugin)
}

/// Materials of a scene while it is read. A material that no shape uses is read, but not kept.
pub(super) struct Materials<'a> {
    scope: Scope<'a>,
    /// Trees by the object's address: each BSDF is one material, however many shapes refer to it.
    trees: HashMap<*const Object, Tree>,
    /// Elements whose faults were returned. They are not read again: a chain of materials, each of which uses the next
    /// one twice, would be read 2^n times.
    faulty: HashSet<*const Object>,
    /// Elements being read, from the outermost.
    open: Vec<*const Object>,
    kept: HashMap<*const Object, u32>,
    /// Copies of materials for boundaries of media.
    bounding: HashMap<(u32, Boundary), u32>,
    /// Indices of the default materials: of shapes that do not emit, and of shapes that do.
    defaults: [Option<u32>; 2],
    /// Index of the material of disks that face what they light.
    null: Option<u32>,
    list: Vec<Material>,
    measured: MeasuredFiles,
}

impl<'a> Materials<'a> {
    pub fn new(scope: Scope<'a>) -> Self {
        Self {
            scope,
            trees: HashMap::new(),
            faulty: HashSet::new(),
            open: Vec::new(),
            kept: HashMap::new(),
            bounding: HashMap::new(),
            defaults: [None; 2],
            null: None,
            list: Vec::new(),
            measured: MeasuredFiles::default(),
        }
    }

    /// Materials in the order of `Scene::materials`.
    pub fn finish(self) -> Vec<Material> {
        self.list
    }

    /// Index in `Scene::materials` of the default material for shapes without a BSDF. As in Mitsuba, it is black where
    /// the shape emits.
    pub fn keep_default(&mut self, emits: bool) -> u32 {
        let list = &mut self.list;
        *self.defaults[usize::from(emits)].get_or_insert_with(|| {
            let (name, albedo) = if emits { ("default of emitters", 0.0) } else { ("default", DEFAULT_REFLECTANCE) };
            let reflectance = Textured::constant(Vec3::splat(albedo));
            let kind = MaterialKind::Surface(SurfaceMaterial::plain(Bsdf::Diffuse { reflectance }));
            list.push(Material { name: name.to_string(), kind, boundary: None });
            list.len() as u32 - 1
        })
    }

    /// Index in `Scene::materials` of the material of disks that face what they light: all light passes.
    pub fn keep_null(&mut self) -> u32 {
        let list = &mut self.list;
        *self.null.get_or_insert_with(|| {
            let kind = MaterialKind::Surface(null_surface());
            list.push(Material { name: "default of facing disks".to_string(), kind, boundary: None });
            list.len() as u32 - 1
        })
    }

    /// Index in `Scene::materials` of a material for shapes that bound media.
    pub fn keep_boundary(&mut self, material: u32, boundary: Boundary) -> u32 {
        let list = &mut self.list;
        *self.bounding.entry((material, boundary)).or_insert_with(|| {
            let copy = Material { boundary: Some(boundary), ..list[material as usize].clone() };
            list.push(copy);
            list.len() as u32 - 1
        })
    }

    /// Index in `Scene::materials` of a BSDF that a shape uses.
    pub fn keep(
        &mut self,
        object: &'a Object,
        shape_id: Option<&str>,
        textures: &mut Textures<'a>,
        warnings: &mut Vec<String>,
    ) -> Result<u32> {
        if let Some(&index) = self.kept.get(&ptr::from_ref(object)) {
            return Ok(index);
        }
        let tree = self.read(object, textures, warnings)?;
        let name = match object.id.as_deref().or(shape_id) {
            Some(id) => id.to_string(),
            None => format!("{} at {}", object.plugin, object.origin.brief()),
        };
        let index = self.push(&name, tree, textures);
        self.kept.insert(ptr::from_ref(object), index);
        Ok(index)
    }

    /// Whether a material of `Scene::materials`, or a part of it, is `hair`.
    pub fn has_fibers(&self, material: u32) -> bool {
        match &self.list[material as usize].kind {
            MaterialKind::Surface(surface) => matches!(surface.bsdf, Bsdf::Hair { .. }),
            MaterialKind::Blend { materials: [first, second], .. }
            | MaterialKind::Sides { front: first, back: second } => self.has_fibers(*first) || self.has_fibers(*second),
        }
    }

    fn push(&mut self, name: &str, tree: Tree, textures: &mut Textures) -> u32 {
        let kind = match tree {
            Tree::Surface(mut surface) => {
                surface.textures_mut().into_iter().for_each(|texture| *texture = textures.keep(*texture));
                MaterialKind::Surface(surface)
            }
            Tree::Blend { mut weight, parts } => {
                weight.texture = weight.texture.map(|texture| textures.keep(texture));
                MaterialKind::Blend { weight, materials: self.push_both(name, *parts, textures) }
            }
            Tree::Sides { parts } => {
                let [front, back] = self.push_both(name, *parts, textures);
                MaterialKind::Sides { front, back }
            }
        };
        self.list.push(Material { name: name.to_string(), kind, boundary: None });
        self.list.len() as u32 - 1
    }

    fn push_both(&mut self, name: &str, parts: [Tree; 2], textures: &mut Textures) -> [u32; 2] {
        parts.map(|part| self.push(name, part, textures))
    }

    /// Checks a BSDF, whether or not a shape uses it.
    pub fn check(&mut self, object: &'a Object, textures: &mut Textures<'a>, warnings: &mut Vec<String>) -> Result<()> {
        self.read(object, textures, warnings).map(drop)
    }

    fn read(&mut self, object: &'a Object, textures: &mut Textures<'a>, warnings: &mut Vec<String>) -> Result<Tree> {
        let key = ptr::from_ref(object);
        if let Some(tree) = self.trees.get(&key) {
            return Ok(tree.clone());
        }
        if self.faulty.contains(&key) {
            return Err(faults::told_before());
        }
        if self.open.contains(&key) {
            return Err(object
                .error(format!("this {} contains itself, directly or through others", object.origin.word("bsdf"))));
        }
        if self.open.len() >= MAX_DEPTH {
            return Err(object.error(format!("BSDFs are nested more than {MAX_DEPTH} deep")));
        }
        self.open.push(key);
        let tree = self.read_new(object, textures, warnings);
        self.open.pop();
        match &tree {
            Ok(tree) => drop(self.trees.insert(key, tree.clone())),
            Err(_) => drop(self.faulty.insert(key)),
        }
        tree
    }

    fn read_new(
        &mut self,
        object: &'a Object,
        textures: &mut Textures<'a>,
        warnings: &mut Vec<String>,
    ) -> Result<Tree> {
        let mut properties = Properties::new(object, &self.scope)?;
        let mut parts = Vec::new();
        if MODIFIERS.contains(&properties.plugin()) {
            let mut faults = Faults::default();
            for nested in properties.objects(Kind::Bsdf) {
                parts.extend(faults.keep(self.read(nested, textures, warnings)));
            }
            faults.into_result()?;
        }
        let mut parameters = Parameters::new(properties, textures, &mut self.measured, warnings);
        let tree = match surfaces::parse(&mut parameters)? {
            Some(bsdf) => {
                let scales_radiance = scales_radiance(&mut parameters, &bsdf)?;
                let film = film::film(&mut parameters, &bsdf)?;
                Tree::Surface(SurfaceMaterial { scales_radiance, film, ..SurfaceMaterial::plain(bsdf) })
            }
            None => modify(&mut parameters, parts)?,
        };
        parameters.finish()?;
        check_texture_count(object, &tree)?;
        if tree.surfaces().len() > MAX_SURFACES {
            return Err(object.error(format!("a material of more than {MAX_SURFACES} surfaces is not supported")));
        }
        if tree.choice_depth() > MAX_CHOICES {
            return Err(object.error(format!("blends within blends, more than {MAX_CHOICES} deep, are not supported")));
        }
        Ok(tree)
    }
}

/// Reads `scale_radiance`, which is not Mitsuba's, of BSDFs that refract light.
fn scales_radiance(parameters: &mut Parameters, bsdf: &Bsdf) -> Result<bool> {
    match bsdf {
        Bsdf::Dielectric { .. } | Bsdf::RoughDielectric { .. } | Bsdf::Principled(_) => {
            Ok(parameters.properties.boolean("scale_radiance")?.unwrap_or(true))
        }
        _ => Ok(true),
    }
}

/// Applies a plugin of [`MODIFIERS`] to its BSDFs, or reads a `null`.
fn modify(parameters: &mut Parameters, parts: Vec<Tree>) -> Result<Tree> {
    let object = parameters.owner();
    let (plugin, word) = (&object.plugin, || object.origin.word("bsdf"));
    let one = |parts: Vec<Tree>| match <[Tree; 1]>::try_from(parts) {
        Ok([only]) => Ok(only),
        Err(_) => Err(object.error(format!("bsdf plugin `{plugin}` needs exactly one nested {}", word()))),
    };
    let result = match &**plugin {
        "twosided" => match <[Tree; 2]>::try_from(parts) {
            Ok([front, back]) => Tree::sides(front, back),
            Err(parts) => one(parts)?.two_sided(),
        },
        "mask" => {
            let opacity = parameters.share("opacity", 0.5)?;
            one(parts)?.masked(opacity)
        }
        "blendbsdf" => Ok(blend(parameters, parts)?),
        "mixturebsdf" => Ok(mixture::mixture(parameters, parts)?),
        "null" => Ok(Tree::null()),
        "polarizer" | "circular" | "retarder" => Ok(polarizing(parameters)?),
        "bumpmap" | "normalmap" => {
            let rules = relief_rules(parameters)?;
            let relief = if &**plugin == "bumpmap" { bump_map(parameters)? } else { normal_map(parameters)? };
            one(parts)?.with_relief(relief, rules)
        }
        "coating" => one(parts)?.coated(coating(parameters)?),
        "sheen" => {
            let base = if parts.is_empty() { Tree::black() } else { one(parts)? };
            base.with_sheen(sheen(parameters)?)
        }
        _ => {
            let supported: Vec<_> = surfaces::READERS.iter().map(|(name, _)| *name).collect();
            let polarizing = POLARIZING.map(|(name, _)| name);
            return Err(object.unsupported(&[&supported[..], &["null"], &MODIFIERS, &polarizing].concat()));
        }
    };
    result.map_err(|message| object.error(message))
}

/// Reads an element that acts on polarization. As in Mitsuba's variants without polarization, it takes its share of the light.
fn polarizing(parameters: &mut Parameters) -> Result<Tree> {
    let object = parameters.owner();
    let plugin = &*object.plugin;
    parameters.properties.ignore(&["theta", "delta", "polarizing", "left_handed"]);
    if let Some(texture) = parameters.properties.texture("transmittance")? {
        return Err(texture.error(format!("the `transmittance` of a `{plugin}` must be a number, not a texture")));
    }
    let transmittance = parameters.constant_reflectance("transmittance", 1.0)?;
    if transmittance != Vec3::splat(transmittance.x) {
        return Err(object.error(format!("the `transmittance` of a `{plugin}` must be the same for all colors")));
    }
    let share = POLARIZING.iter().find(|(name, _)| *name == plugin).map_or(1.0, |(_, share)| *share);
    let message =
        format!("bsdf plugin `{plugin}` acts on intensity alone, as in Mitsuba's variants without polarization");
    parameters.warnings.push(format!("{}: {message}", object.origin));
    Ok(Tree::sheet(share * transmittance.x))
}

fn blend(parameters: &mut Parameters, parts: Vec<Tree>) -> Result<Tree> {
    let object = parameters.owner();
    let parts = <[Tree; 2]>::try_from(parts).map_err(|_| {
        object.error(format!("bsdf plugin `blendbsdf` needs exactly two nested {}s", object.origin.word("bsdf")))
    })?;
    if !parameters.properties.has("weight") {
        return Err(object.error("bsdf plugin `blendbsdf` needs its parameter `weight`"));
    }
    Ok(Tree::Blend { weight: parameters.share("weight", 0.5)?, parts: Box::new(parts) })
}

fn bump_map(parameters: &mut Parameters) -> Result<Relief> {
    let scale = parameters.properties.float("scale")?.unwrap_or(1.0);
    let (texture, factor) = parameters.relief_texture(None, Role::Heights)?;
    Ok(Relief::Bump { texture, scale: scale * factor })
}

fn normal_map(parameters: &mut Parameters) -> Result<Relief> {
    let (texture, _) = parameters.relief_texture(Some("normalmap"), Role::Normals)?;
    Ok(Relief::NormalMap { texture })
}

/// Reads the corrections of invalid normals. `raise_invalid_normals` is not Mitsuba's. Normals that still face away are always flipped.
fn relief_rules(parameters: &mut Parameters) -> Result<ReliefRules> {
    let location = parameters.properties.location("flip_invalid_normals");
    if parameters.properties.boolean("flip_invalid_normals")? == Some(false) {
        return Err(location.error("`flip_invalid_normals` cannot be switched off; leave it out"));
    }
    Ok(ReliefRules {
        shadows: parameters.properties.boolean("use_shadowing_function")?.unwrap_or(true),
        raises: parameters.properties.boolean("raise_invalid_normals")?.unwrap_or(false),
    })
}

/// Reads a `coating`, a plugin of Mitsuba 0.6 that Mitsuba 3 lacks.
fn coating(parameters: &mut Parameters) -> Result<Coating> {
    parameters.properties.ignore_sampling(&["specular_sampling_weight"]);
    for name in ["sigma_a", "specular_reflectance"] {
        if let Some(texture) = parameters.properties.texture(name)? {
            return Err(texture.error(format!("`{name}` of a `coating` must be a color, not a texture")));
        }
    }
    let eta = ior::relative(&mut parameters.properties, "bk7")?;
    let thickness = parameters.properties.positive_float("thickness", 1.0)?;
    let absorption = parameters.properties.color("sigma_a")?.unwrap_or(Vec3::ZERO);
    let specular_reflectance = parameters.constant_reflectance("specular_reflectance", 1.0)?;
    Ok(Coating { eta, optical_thickness: absorption * thickness, specular_reflectance })
}

/// Reads a `sheen`, a plugin that Mitsuba lacks.
fn sheen(parameters: &mut Parameters) -> Result<Sheen> {
    Ok(Sheen {
        reflectance: parameters.reflectance("reflectance", 1.0)?,
        roughness: parameters.share("roughness", 0.5)?,
    })
}

fn check_texture_count(object: &Object, tree: &Tree) -> Result<()> {
    let count = |surface: &SurfaceMaterial| surface.clone().parameter_textures_mut().len();
    match tree.surfaces().into_iter().map(count).find(|&count| count > MAX_TEXTURES) {
        Some(count) => {
            Err(object.error(format!("{count} textured parameters: a material may have at most {MAX_TEXTURES}")))
        }
        None => Ok(()),
    }
}
