//! Materials as `principled` surfaces with their modifiers.

use std::collections::HashMap;

use openusd::sdf;

use super::asset::{Asset, Prim};
use super::surfaces::{Names, names_of};
use super::textures::{Images, Source, Texture, followed, scaled};
use super::values;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, nested, number, object, two_sided};
use crate::scene::description::object::{Object, Value};

/// Least index of refraction of a `principled`.
const LEAST_IOR: f64 = 1.001;
/// Gray of what has neither material nor color.
const NO_COLOR: [f64; 3] = [0.18; 3];

/// What covers a shape.
#[derive(Debug, Clone)]
pub(super) struct Covering {
    /// `id` of the material.
    pub id: String,
    /// `area` emitter, where the material emits.
    pub emitter: Option<Object>,
    /// Primvar of the texture coordinates.
    pub primvar: Option<String>,
    /// Primvar of the colors of vertices that the material shows.
    pub colors: Option<String>,
}

/// Color of a shape besides its material: primvars `displayColor` and `displayOpacity`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Display {
    /// One color; `None` where it varies, or is not given.
    pub color: Option<[f64; 3]>,
    /// Whether the colors vary over the shape.
    pub varies: bool,
    pub opacity: f64,
}

impl Display {
    fn key(&self) -> (Option<[u64; 3]>, bool, u64) {
        (self.color.map(|color| color.map(f64::to_bits)), self.varies, self.opacity.to_bits())
    }
}

/// Facts that decide a material: its path, or the colors of a shape without one.
type Key = (Option<sdf::Path>, (Option<[u64; 3]>, bool, u64));

/// Materials in use.
#[derive(Default)]
pub(super) struct Materials {
    known: HashMap<Key, Covering>,
    objects: Vec<(String, Object)>,
    pub images: Images,
}

/// Input of a surface.
enum Input {
    /// Numbers of the input; one number stands for all.
    Constant([f64; 3]),
    Texture(Box<Texture>),
    /// A primvar by its name.
    Primvar(String),
}

impl Materials {
    /// Materials with their ids.
    pub fn take_objects(self) -> Vec<(String, Object)> {
        self.objects
    }

    /// Adds a material. Returns its id.
    pub fn add(&mut self, name: &str, surface: Object) -> String {
        let id = format!("material{}_{}", self.objects.len(), plain(name));
        self.objects.push((id.clone(), surface));
        id
    }

    /// What a material makes of a shape with these colors.
    pub fn covering(&mut self, asset: &Asset, material: Option<&sdf::Path>, display: &Display) -> Result<Covering> {
        let key: Key = (material.cloned(), display.key());
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let surface = material.map(|path| surface_of(asset, path)).transpose()?.flatten();
        let covering = match surface {
            Some((surface, names)) => {
                let path = material.map_or("", |path| path.name().unwrap_or_default()).to_owned();
                let mut reader = Reader { surface: &surface, names, images: &mut self.images, primvars: Vec::new() };
                let (bsdf, emitter, colors) = reader.read(display)?;
                let primvar = reader.primvar();
                Covering { id: self.add(&path, bsdf), emitter, primvar, colors }
            }
            None => {
                let shown = match display.varies {
                    true => nested(vertex_color()),
                    false => color(display.color.unwrap_or(NO_COLOR).map(|channel| channel.clamp(0.0, 1.0) as f32)),
                };
                let bsdf = two_sided(object(Kind::Bsdf, "diffuse", [("reflectance", shown)]));
                let bsdf = masked(bsdf, (display.opacity < 1.0).then(|| number(display.opacity as f32)));
                let colors = display.varies.then(|| "displayColor".to_owned());
                Covering { id: self.add("displayColor", bsdf), emitter: None, primvar: None, colors }
            }
        };
        self.known.insert(key, covering.clone());
        Ok(covering)
    }
}

/// The surface shader of a material with the names of its inputs; `None` where there is none that is known.
fn surface_of<'a>(asset: &'a Asset, path: &sdf::Path) -> Result<Option<(Prim<'a>, &'static Names)>> {
    let material = asset.prim(path)?;
    let is_surface = |name: &&str| *name == "outputs:surface" || name.ends_with(":surface");
    let mut outputs: Vec<&str> =
        material.names().filter(|name| name.starts_with("outputs:")).filter(is_surface).collect();
    // The surface for all renderers comes first.
    outputs.sort_by_key(|name| (*name != "outputs:surface", name.to_owned()));
    let mut unknown = None;
    for output in outputs {
        let (shader, _) = followed(&material, output)?;
        if shader.path == material.path {
            continue;
        }
        let id = shader.text("info:id")?.unwrap_or_default();
        if let Some(names) = names_of(&id) {
            return Ok(Some((shader, names)));
        }
        unknown.get_or_insert(id);
    }
    let message = match unknown {
        Some(id) if id.is_empty() => "its surface shader has no `info:id`; its display color is rendered".to_owned(),
        Some(id) => format!("its surface `{id}` is not rendered; its display color is"),
        None => "it has no surface; its display color is rendered".to_owned(),
    };
    asset.warn_of(path, message);
    Ok(None)
}

/// Reader of one material.
struct Reader<'r, 'a> {
    surface: &'r Prim<'a>,
    names: &'static Names,
    images: &'r mut Images,
    /// Primvars of texture coordinates that its textures use.
    primvars: Vec<String>,
}

impl Reader<'_, '_> {
    fn asset(&self) -> &Asset {
        self.surface.asset
    }

    fn warn(&self, message: &str) {
        self.asset().warn_of(&self.surface.path, message);
    }

    /// The primvar of texture coordinates that most textures use.
    fn primvar(&self) -> Option<String> {
        let first = self.primvars.first()?;
        if self.primvars.iter().any(|other| other != first) {
            self.warn(&format!("its textures use several primvars of coordinates; `{first}` is used for all"));
        }
        Some(first.clone())
    }

    /// Input by its name without `inputs:`; `None` where it has no value.
    fn input(&mut self, name: &str) -> Result<Option<Input>> {
        if name.is_empty() {
            return Ok(None);
        }
        let (prim, property) = followed(self.surface, &format!("inputs:{name}"))?;
        if !property.starts_with("outputs:") {
            let value = prim.value(&property)?;
            let constant = value.as_ref().and_then(|value| match values::triples(value) {
                Some(list) => list.first().copied(),
                None => values::number(value).map(|number| [number; 3]),
            });
            return Ok(constant.filter(|list| list.iter().all(|number| number.is_finite())).map(Input::Constant));
        }
        let id = prim.text("info:id")?.unwrap_or_default();
        if id == "UsdUVTexture" {
            return Ok(Some(match Texture::of(&prim, &property)? {
                Source::Constant([red, green, blue, _]) => Input::Constant([red, green, blue]),
                Source::Texture(texture) => {
                    self.primvars.push(texture.primvar.clone());
                    Input::Texture(texture)
                }
            }));
        }
        if id.starts_with("UsdPrimvarReader") {
            let (holder, property) = followed(&prim, "inputs:varname")?;
            return Ok(holder.text(&property)?.map(Input::Primvar));
        }
        self.warn(&format!("its input `{name}` comes from the node `{id}`, which is not read; the default is used"));
        Ok(None)
    }

    /// Number of an input between 0 and 1, or a texture of numbers. A primvar counts as the default.
    fn number(&mut self, name: &str, default: f64, tag: &str, to: impl Fn(f64) -> f64) -> Result<Value> {
        Ok(match self.input(name)? {
            Some(Input::Constant([value, ..])) => number(to(value.clamp(0.0, 1.0)) as f32),
            Some(Input::Texture(texture)) => nested(self.images.numbers(self.surface.asset, &texture, tag, to)?),
            Some(Input::Primvar(primvar)) => {
                self.warn(&format!("its input `{name}` comes from the primvar `{primvar}`; the default is used"));
                number(to(default) as f32)
            }
            None => number(to(default) as f32),
        })
    }

    /// Number of an input that must be constant.
    fn constant(&mut self, name: &str, default: f64) -> Result<f64> {
        Ok(match self.input(name)? {
            Some(Input::Constant([value, ..])) => value,
            Some(Input::Texture(texture)) => {
                self.warn(&format!("the texture of its input `{name}` is taken for its mean"));
                self.images.mean(self.surface.asset, &texture)?[0]
            }
            _ => default,
        })
    }

    /// The BSDF, the emitter, and the primvar of colors.
    fn read(&mut self, display: &Display) -> Result<(Object, Option<Object>, Option<String>)> {
        let names = self.names;
        let mut colors = None;
        let weight = if names.base_weight.is_empty() { 1.0 } else { self.constant(names.base_weight, 1.0)? };
        let base = match self.input(names.base_color)? {
            Some(Input::Constant(rgb)) => Base::Constant(rgb.map(|channel| (channel * weight).clamp(0.0, 1.0))),
            Some(Input::Texture(texture)) => Base::Texture(texture),
            Some(Input::Primvar(primvar)) if display.varies && primvar == "displayColor" => {
                colors = Some(primvar);
                Base::Vertices
            }
            Some(Input::Primvar(primvar)) if primvar == "displayColor" => {
                let rgb = display.color.unwrap_or(NO_COLOR);
                Base::Constant(rgb.map(|channel| (channel * weight).clamp(0.0, 1.0)))
            }
            Some(Input::Primvar(primvar)) => {
                colors = Some(primvar);
                Base::Vertices
            }
            None => Base::Constant([names.default_color * weight; 3]),
        };
        let specular_workflow = names.is_preview && self.constant("useSpecularWorkflow", 0.0)? == 1.0;
        let ior = self.constant(names.ior, 1.5)?.max(LEAST_IOR);
        let shown = match &base {
            Base::Constant(rgb) => color(rgb.map(|channel| channel as f32)),
            Base::Texture(texture) => {
                nested(scaled(self.images.color(self.surface.asset, texture)?, [weight.clamp(0.0, 1.0) as f32; 3]))
            }
            Base::Vertices => nested(scaled(vertex_color(), [weight.clamp(0.0, 1.0) as f32; 3])),
        };
        let roughness = self.number(names.roughness, names.default_roughness, "number", |value| value)?;
        let mut bsdf = match specular_workflow {
            true => self.specular(&base, shown)?,
            false => {
                let metallic = self.number(names.metallic, 0.0, "number", |value| value)?;
                object(Kind::Bsdf, "principled", [("base_color", shown), ("metallic", metallic)])
                    .with("eta", number(ior as f32))
            }
        };
        bsdf = bsdf.with("roughness", roughness);
        if self.constant(names.specular_weight, 1.0)? != 1.0 {
            self.warn(&format!(
                "its `{}` is ignored; highlights follow its index of refraction",
                names.specular_weight
            ));
        }
        let coat = self.constant(names.coat, 0.0)?.clamp(0.0, 1.0);
        if coat > 0.0 {
            let roughness = self.constant(names.coat_roughness, names.default_coat_roughness)?.clamp(0.0, 1.0);
            // The gloss that has the coat's roughness in Burley's model: alpha = 0.1 + gloss (0.001 - 0.1).
            let gloss = ((0.1 - roughness * roughness) / 0.099).clamp(0.0, 1.0);
            bsdf = bsdf.with("clearcoat", number(coat as f32)).with("clearcoat_gloss", number(gloss as f32));
        }
        let transmission = self.constant(names.transmission, 0.0)?.clamp(0.0, 1.0);
        if transmission > 0.0 {
            bsdf = bsdf.with("spec_trans", number(transmission as f32));
        }
        bsdf = self.with_normals(bsdf)?;
        // A dielectric body transmits from both sides already.
        let surface = if transmission > 0.0 { bsdf } else { two_sided(bsdf) };
        let (opacity, share) = self.opacity(display)?;
        let emitter = self.emitter(share)?;
        Ok((masked(surface, opacity), emitter, colors))
    }

    /// A surface with a specular color: a dielectric with that reflectance at normal incidence, or a metal.
    fn specular(&mut self, base: &Base, shown: Value) -> Result<Object> {
        let input = self.input("specularColor")?;
        let specular = match &input {
            Some(Input::Constant(rgb)) => *rgb,
            Some(Input::Texture(texture)) => self.images.mean(self.surface.asset, texture)?,
            _ => [0.0; 3],
        };
        let mean = (specular.iter().sum::<f64>() / 3.0).clamp(0.0, 0.98);
        let is_black = matches!(base, Base::Constant(rgb) if rgb.iter().all(|&channel| channel < 1.0e-3));
        let strongest = specular.into_iter().fold(0.0, f64::max);
        if is_black && strongest > 0.1 {
            let shown = match &input {
                Some(Input::Texture(texture)) => nested(self.images.color(self.surface.asset, texture)?),
                _ => color(specular.map(|channel| channel.clamp(0.0, 1.0) as f32)),
            };
            return Ok(object(Kind::Bsdf, "principled", [("base_color", shown), ("metallic", number(1.0))]));
        }
        if matches!(input, Some(Input::Texture(_))) || specular.iter().any(|channel| (channel - mean).abs() > 0.01) {
            self.warn("its specular color is taken for its mean, because its diffuse color is not black");
        }
        let root = mean.sqrt();
        let eta = ((1.0 + root) / (1.0 - root)).max(LEAST_IOR);
        Ok(object(Kind::Bsdf, "principled", [("base_color", shown), ("eta", number(eta as f32))]))
    }

    fn with_normals(&mut self, bsdf: Object) -> Result<Object> {
        match self.input(self.names.normal)? {
            Some(Input::Texture(texture)) => {
                let normals = self.images.normals(self.surface.asset, &texture)?;
                Ok(object(Kind::Bsdf, "normalmap", [("normalmap", nested(normals)), ("surface", nested(bsdf))]))
            }
            _ => Ok(bsdf),
        }
    }

    /// Opacity where the surface has holes, and its value where that is one number.
    fn opacity(&mut self, display: &Display) -> Result<(Option<Value>, f64)> {
        let threshold = if self.names.is_preview { self.constant("opacityThreshold", 0.0)? } else { 0.0 };
        let cut = move |value: f64| match threshold > 0.0 {
            true => f64::from(u8::from(value >= threshold)),
            false => value,
        };
        Ok(match self.input(self.names.opacity)? {
            Some(Input::Constant([value, ..])) if cut(value) < 1.0 => {
                let share = cut(value.clamp(0.0, 1.0));
                (Some(number(share as f32)), share)
            }
            Some(Input::Texture(texture)) => {
                let tag = format!("opacity{threshold}");
                let texture = self.images.numbers(self.surface.asset, &texture, &tag, cut)?;
                (Some(nested(texture)), 1.0)
            }
            Some(Input::Primvar(primvar)) if primvar == "displayOpacity" && cut(display.opacity) < 1.0 => {
                (Some(number(cut(display.opacity) as f32)), cut(display.opacity))
            }
            _ => (None, 1.0),
        })
    }

    /// `area` emitter of what shines under an opacity.
    fn emitter(&mut self, opacity: f64) -> Result<Option<Object>> {
        let names = self.names;
        let weight = match names.emission_weight {
            "" => 1.0,
            weight => self.constant(weight, 0.0)?,
        } * opacity;
        if weight <= 0.0 {
            return Ok(None);
        }
        let radiance = match self.input(names.emission)? {
            Some(Input::Constant(rgb)) if rgb.iter().any(|&channel| channel > 0.0) => {
                color(rgb.map(|channel| (channel * weight).max(0.0) as f32))
            }
            Some(Input::Texture(texture)) => {
                nested(scaled(self.images.color(self.surface.asset, &texture)?, [weight as f32; 3]))
            }
            None if !names.emission_weight.is_empty() => color([weight as f32; 3]),
            _ => return Ok(None),
        };
        Ok(Some(object(Kind::Emitter, "area", [("radiance", radiance)])))
    }
}

/// Base color of a surface.
enum Base {
    Constant([f64; 3]),
    Texture(Box<Texture>),
    Vertices,
}

fn vertex_color() -> Object {
    object(Kind::Texture, "mesh_attribute", [("name", Value::Text("vertex_color".into()))])
}

fn masked(surface: Object, opacity: Option<Value>) -> Object {
    match opacity {
        None => surface,
        Some(opacity) => object(Kind::Bsdf, "mask", [("opacity", opacity), ("surface", nested(surface))]),
    }
}

/// The name with every character that is neither a letter nor a digit replaced by `_`.
pub(super) fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}
