//! Materials as `principled` surfaces with their modifiers.

use std::collections::HashMap;

use gltf::Material;
use gltf::material::AlphaMode;

use super::asset::Asset;
use super::images::{BaseColor, Coding, Images, TextureUse, scaled};
use super::specular_glossiness;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, nested, number, object, two_sided};
use crate::scene::description::object::{Object, Value};

/// Index of refraction of a material that gives none.
const DEFAULT_IOR: f32 = 1.5;
/// Least index of refraction of a `principled`.
const LEAST_IOR: f32 = 1.001;

/// Extensions of materials whose textures are not read.
const UNTEXTURED: [&str; 4] =
    ["KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_anisotropy"];

/// Source of a primitive's color besides the material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Coloring {
    /// No other.
    None,
    /// The colors of the vertices.
    Vertices,
}

/// What covers a shape.
#[derive(Debug, Clone)]
pub(super) struct Covering {
    /// `id` of the material.
    pub id: String,
    /// `area` emitter, where the material emits.
    pub emitter: Option<Object>,
    /// Set of texture coordinates that the textures use.
    pub uv_set: u32,
    /// Factor of the vertex colors, where the material shows them.
    pub color_factor: Option<[f32; 3]>,
}

/// Materials in use.
#[derive(Default)]
pub(super) struct Materials {
    known: HashMap<(Option<usize>, Coloring), Covering>,
    objects: Vec<(String, Object)>,
}

impl Materials {
    /// Materials with their ids.
    pub fn take_objects(self) -> Vec<(String, Object)> {
        self.objects
    }

    /// What a material makes of a shape.
    pub fn covering<'a>(
        &mut self,
        asset: &'a Asset,
        images: &mut Images<'a>,
        material: &Material<'a>,
        coloring: Coloring,
    ) -> Result<Covering> {
        let key = (material.index(), coloring);
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let name = plain(material.name().unwrap_or_default());
        let place = material.index().map_or("default".to_owned(), |index| index.to_string());
        let suffix = if coloring == Coloring::Vertices { "_colored" } else { "" };
        let id = format!("material{place}_{name}{suffix}");
        let mut reader = Reader { asset, images, material, label: material_label(material), uv_sets: Vec::new() };
        let (bsdf, emitter, color_factor) = reader.read(coloring)?;
        let uv_set = reader.uv_set();
        let covering = Covering { id: id.clone(), emitter, uv_set, color_factor };
        self.objects.push((id, bsdf));
        self.known.insert(key, covering.clone());
        Ok(covering)
    }
}

/// Reader of one material.
struct Reader<'r, 'a> {
    asset: &'a Asset,
    images: &'r mut Images<'a>,
    material: &'r Material<'a>,
    /// Name of the material in messages.
    label: String,
    /// Sets of texture coordinates that its textures use.
    uv_sets: Vec<u32>,
}

impl<'a> Reader<'_, 'a> {
    fn warn(&self, message: &str) {
        self.asset.warn(format!("{}: {message}", self.label));
    }

    /// The set of texture coordinates that most textures use.
    fn uv_set(&self) -> u32 {
        let Some(&first) = self.uv_sets.first() else { return 0 };
        if self.uv_sets.iter().any(|&set| set != first) {
            self.warn(&format!("its textures use several sets of coordinates; set {first} is used for all"));
        }
        first
    }

    fn keep(&mut self, texture: TextureUse<'a>) -> TextureUse<'a> {
        self.uv_sets.push(texture.uv_set);
        texture
    }

    fn info(&mut self, info: Option<gltf::texture::Info<'a>>) -> Option<TextureUse<'a>> {
        info.map(|info| self.keep(TextureUse::of(&info)))
    }

    /// The BSDF, the emitter and the factor of vertex colors.
    fn read(&mut self, coloring: Coloring) -> Result<(Object, Option<Object>, Option<[f32; 3]>)> {
        self.warn_of_textures();
        let metallic = self.material.pbr_metallic_roughness();
        let base_texture = self.info(metallic.base_color_texture());
        let mut base = BaseColor { factor: metallic.base_color_factor(), texture: base_texture };
        let (mut bsdf, transmits);
        let mut color_factor = None;
        if self.material.unlit() {
            let emitted = self.color(&base, coloring, &mut color_factor)?;
            let black = object(Kind::Bsdf, "diffuse", [("reflectance", color([0.0; 3]))]);
            self.warn("it is unlit (KHR_materials_unlit): it emits its color and reflects nothing");
            let emitter = object(Kind::Emitter, "area", [("radiance", emitted)]);
            return Ok((self.masked(two_sided(black), &base)?, Some(emitter), color_factor));
        }
        if let Some(specular) = self.material.pbr_specular_glossiness() {
            let diffuse = self.info(specular.diffuse_texture());
            let gloss = self.info(specular.specular_glossiness_texture());
            base = BaseColor { factor: specular.diffuse_factor(), texture: diffuse };
            if coloring == Coloring::Vertices {
                self.warn("vertex colors cannot stand beside KHR_materials_pbrSpecularGlossiness; they are ignored");
            }
            transmits = false;
            bsdf = specular_glossiness::principled(self.images, &specular, &base, gloss.as_ref())?;
        } else {
            let shown = self.color(&base, coloring, &mut color_factor)?;
            bsdf = object(Kind::Bsdf, "principled", [("base_color", shown)]);
            let texture = self.info(metallic.metallic_roughness_texture());
            let roughness =
                self.number(texture.as_ref(), "roughness", metallic.roughness_factor(), |texel| texel[1])?;
            let metal = self.number(texture.as_ref(), "metallic", metallic.metallic_factor(), |texel| texel[2])?;
            bsdf = bsdf.with("roughness", roughness).with("metallic", metal);
            bsdf = self.extended(bsdf);
            (bsdf, transmits) = self.transmission(bsdf)?;
        }
        bsdf = self.with_normals(bsdf)?;
        // A dielectric body transmits from both sides already.
        let surface = if transmits { bsdf } else { two_sided(bsdf) };
        let surface = self.thin_transmission(surface, &base)?;
        let emitter = self.emitter()?;
        Ok((self.masked(surface, &base)?, emitter, color_factor))
    }

    fn warn_of_textures(&self) {
        for extension in UNTEXTURED {
            let value = self.material.extension_value(extension);
            let has_texture = value.and_then(|value| value.as_object());
            if has_texture.is_some_and(|value| value.keys().any(|key| key.ends_with("Texture"))) {
                self.warn(&format!("the textures of {extension} are ignored"));
            }
        }
        if let Some(specular) = self.material.specular()
            && (specular.specular_texture().is_some() || specular.specular_color_texture().is_some())
        {
            self.warn("the textures of KHR_materials_specular are ignored");
        }
    }

    /// Base color: a color, a texture, or the colors of the vertices.
    fn color(
        &mut self,
        base: &BaseColor<'a>,
        coloring: Coloring,
        color_factor: &mut Option<[f32; 3]>,
    ) -> Result<Value> {
        let [red, green, blue, _] = base.factor;
        let factor = [red, green, blue];
        let has_textures = base.texture.is_some() || self.material_has_textures();
        match (&base.texture, coloring) {
            (_, Coloring::Vertices) if has_textures => {
                self.warn("vertex colors cannot stand beside textures; the vertex colors are ignored");
            }
            (None, Coloring::Vertices) => {
                *color_factor = Some(factor);
                let name = Value::Text("vertex_color".into());
                return Ok(nested(object(Kind::Texture, "mesh_attribute", [("name", name)])));
            }
            _ => {}
        }
        match &base.texture {
            Some(texture) => Ok(nested(scaled(self.images.bitmap(texture, Coding::Srgb)?, factor))),
            None => Ok(color(factor)),
        }
    }

    fn material_has_textures(&self) -> bool {
        let metallic = self.material.pbr_metallic_roughness();
        metallic.metallic_roughness_texture().is_some()
            || self.material.normal_texture().is_some()
            || self.material.emissive_texture().is_some()
    }

    /// A number, or the product of a number and one channel of a texture.
    fn number(
        &mut self,
        texture: Option<&TextureUse<'a>>,
        tag: &str,
        factor: f32,
        channel: impl Fn([u8; 4]) -> u8,
    ) -> Result<Value> {
        let factor = factor.clamp(0.0, 1.0);
        match texture.filter(|_| factor > 0.0) {
            Some(texture) => Ok(nested(scaled(self.images.numbers(texture, tag, channel)?, [factor; 3]))),
            None => Ok(number(factor)),
        }
    }

    fn ior(&self) -> f32 {
        self.material.ior().unwrap_or(DEFAULT_IOR).max(LEAST_IOR)
    }

    /// Adds what extensions say of the reflection.
    fn extended(&self, mut bsdf: Object) -> Object {
        let mut eta = self.ior();
        if let Some(specular) = self.material.specular()
            && self.material.transmission().is_none()
        {
            let tint = specular.specular_color_factor();
            if tint.iter().any(|&channel| channel != tint[0]) {
                self.warn("the color of KHR_materials_specular is taken for its mean");
            }
            let mean = tint.iter().sum::<f32>() / 3.0;
            let root = (eta - 1.0) / (eta + 1.0) * (specular.specular_factor() * mean).max(0.0).sqrt();
            eta = ((1.0 + root.min(0.9)) / (1.0 - root.min(0.9))).max(LEAST_IOR);
        }
        bsdf = bsdf.with("eta", number(eta));
        let read = |extension: &str, key: &str| {
            let value = self.material.extension_value(extension)?.get(key)?.as_f64()?;
            Some((value as f32).clamp(0.0, 1.0))
        };
        if let Some(strength) = read("KHR_materials_clearcoat", "clearcoatFactor").filter(|&strength| strength > 0.0) {
            let roughness = read("KHR_materials_clearcoat", "clearcoatRoughnessFactor").unwrap_or(0.0);
            // The gloss that has the coat's roughness in Burley's model: alpha = 0.1 + gloss (0.001 - 0.1).
            let gloss = ((0.1 - roughness * roughness) / 0.099).clamp(0.0, 1.0);
            bsdf = bsdf.with("clearcoat", number(strength)).with("clearcoat_gloss", number(gloss));
        }
        let sheen = self.material.extension_value("KHR_materials_sheen");
        if let Some(sheen) = sheen.and_then(|sheen| sheen.get("sheenColorFactor")?.as_array()) {
            let channels: Vec<f32> = sheen.iter().filter_map(|channel| Some(channel.as_f64()? as f32)).collect();
            let strength = channels.iter().copied().fold(0.0, f32::max).min(1.0);
            if channels.iter().any(|&channel| channel != channels[0]) {
                self.warn("the color of KHR_materials_sheen is taken for white");
            }
            bsdf = bsdf.with("sheen", number(strength));
        }
        if let Some(strength) = read("KHR_materials_anisotropy", "anisotropyStrength").filter(|&value| value > 0.0) {
            if read("KHR_materials_anisotropy", "anisotropyRotation").is_some_and(|rotation| rotation != 0.0) {
                self.warn("the rotation of KHR_materials_anisotropy is ignored");
            }
            bsdf = bsdf.with("anisotropic", number(strength));
        }
        bsdf
    }

    /// Share of the transmission, where it is above 0.
    fn transmitted(&mut self) -> Result<Option<Value>> {
        let Some(transmission) = self.material.transmission() else { return Ok(None) };
        if transmission.transmission_factor() <= 0.0 {
            return Ok(None);
        }
        let texture = self.info(transmission.transmission_texture());
        self.number(texture.as_ref(), "transmission", transmission.transmission_factor(), |texel| texel[0]).map(Some)
    }

    fn is_solid(&self) -> bool {
        self.material.volume().is_some_and(|volume| volume.thickness_factor() > 0.0)
    }

    /// Adds the transmission of a body. Returns whether there is any.
    fn transmission(&mut self, bsdf: Object) -> Result<(Object, bool)> {
        if !self.is_solid() {
            return Ok((bsdf, false));
        }
        let Some(share) = self.transmitted()? else { return Ok((bsdf, false)) };
        let volume = self.material.volume();
        let absorbs = volume.is_some_and(|v| v.attenuation_color() != [1.0; 3] && v.attenuation_distance().is_finite());
        if absorbs {
            self.warn("the absorption within it (KHR_materials_volume) is not rendered");
        }
        Ok((bsdf.with("spec_trans", share), true))
    }

    /// Mixes in the transmission of a sheet without thickness.
    fn thin_transmission(&mut self, surface: Object, base: &BaseColor<'a>) -> Result<Object> {
        if self.is_solid() {
            return Ok(surface);
        }
        let Some(share) = self.transmitted()? else { return Ok(surface) };
        if self.material.pbr_metallic_roughness().roughness_factor() > 0.1 {
            self.warn("light goes straight through it: the roughness of a thin transmission is not rendered");
        }
        let tint = self.color(base, Coloring::None, &mut None)?;
        let sheet =
            object(Kind::Bsdf, "thindielectric", [("int_ior", number(self.ior())), ("specular_transmittance", tint)]);
        if matches!(share, Value::Float(1.0)) {
            return Ok(sheet);
        }
        let parts = [("weight", share), ("opaque", nested(surface)), ("sheet", nested(sheet))];
        Ok(object(Kind::Bsdf, "blendbsdf", parts))
    }

    fn with_normals(&mut self, bsdf: Object) -> Result<Object> {
        let Some(normals) = self.material.normal_texture() else { return Ok(bsdf) };
        let texture = self.keep(TextureUse::of_normals(&normals));
        let scale = normals.scale();
        let bitmap = match scale == 1.0 {
            true => self.images.bitmap(&texture, Coding::Linear)?,
            false => {
                let slope = |byte: u8| ((f32::from(byte) - 127.5) * scale + 127.5).round().clamp(0.0, 255.0) as u8;
                let tag = format!("normals{scale}");
                let scaled = |texel: [u8; 4], _: f32, _: f32| [slope(texel[0]), slope(texel[1]), texel[2]];
                self.images.made(&texture, &tag, Coding::Linear, scaled)?
            }
        };
        Ok(object(Kind::Bsdf, "normalmap", [("normalmap", nested(bitmap)), ("surface", nested(bsdf))]))
    }

    fn emitter(&mut self) -> Result<Option<Object>> {
        let strength = self.material.emissive_strength().unwrap_or(1.0);
        let factor = self.material.emissive_factor().map(|channel| (channel * strength).max(0.0));
        let texture = self.info(self.material.emissive_texture());
        if factor == [0.0; 3] {
            return Ok(None);
        }
        if self.material.double_sided() {
            self.warn("it emits from its front only, though it is double-sided");
        }
        let radiance = match texture {
            Some(texture) => nested(scaled(self.images.bitmap(&texture, Coding::Srgb)?, factor)),
            None => color(factor),
        };
        Ok(Some(object(Kind::Emitter, "area", [("radiance", radiance)])))
    }

    /// Surface with holes, where the alpha mode makes any.
    fn masked(&mut self, surface: Object, base: &BaseColor<'a>) -> Result<Object> {
        let factor = base.factor[3].clamp(0.0, 1.0);
        let opacity = match (self.material.alpha_mode(), &base.texture) {
            (AlphaMode::Opaque, _) => return Ok(surface),
            (AlphaMode::Blend, None) if factor == 1.0 => return Ok(surface),
            (AlphaMode::Blend, None) => number(factor),
            (AlphaMode::Blend, Some(texture)) => {
                nested(scaled(self.images.numbers(texture, "alpha", |texel| texel[3])?, [factor; 3]))
            }
            (AlphaMode::Mask, texture) => {
                let cutoff = self.material.alpha_cutoff().unwrap_or(0.5);
                let is_kept = move |alpha: f32| if alpha * factor >= cutoff { 255 } else { 0 };
                match texture {
                    None => number(f32::from(u8::from(factor >= cutoff))),
                    Some(texture) => {
                        let tag = format!("cutoff{}", cutoff / factor.max(1.0e-6));
                        let kept = |texel: [u8; 4]| is_kept(f32::from(texel[3]) / 255.0);
                        nested(self.images.numbers(texture, &tag, kept)?)
                    }
                }
            }
        };
        Ok(object(Kind::Bsdf, "mask", [("opacity", opacity), ("surface", nested(surface))]))
    }
}

/// The name with every character that is neither a letter nor a digit replaced by `_`.
pub(super) fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}

fn material_label(material: &Material) -> String {
    match (material.name(), material.index()) {
        (Some(name), _) => format!("material `{name}`"),
        (None, Some(index)) => format!("material {index}"),
        (None, None) => "the default material".to_owned(),
    }
}
