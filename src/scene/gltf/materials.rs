//! Materials as `principled` surfaces with their modifiers.

use std::collections::HashMap;

use gltf::Material;

use super::alpha::{Opacity, radiance};
use super::asset::{Asset, plain};
use super::film::film;
use super::images::{BaseColor, Coding, Images, TextureUse, scaled};
use super::specular_glossiness;
use super::volume;
use super::wearer::{Coloring, Wearer};
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

/// What covers a shape.
#[derive(Debug, Clone)]
pub(super) struct Covering {
    /// `id` of the material.
    pub id: String,
    /// `area` emitter, where the material emits.
    pub emitter: Option<Object>,
    /// `id` of the medium within the shape.
    pub medium: Option<String>,
    /// Set of texture coordinates that the textures use.
    pub uv_set: u32,
    /// Factor of the vertex colors, where the material shows them.
    pub color_factor: Option<[f32; 3]>,
}

/// Materials in use.
#[derive(Default)]
pub(super) struct Materials {
    known: HashMap<(Option<usize>, Wearer), Covering>,
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
        wearer: Wearer,
    ) -> Result<Covering> {
        let key = (material.index(), wearer);
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let name = plain(material.name().unwrap_or_default());
        let place = material.index().map_or("default".to_owned(), |index| index.to_string());
        let id = format!("material{place}_{name}{}", wearer.suffix());
        let label = material_label(material);
        let mut reader = Reader { asset, images, material, wearer, label, uv_sets: Vec::new() };
        let (bsdf, emitter, color_factor) = reader.read()?;
        let uv_set = reader.uv_set();
        let medium = volume::medium(material).map(|medium| {
            let id = format!("medium{place}_{name}{}", wearer.suffix());
            self.objects.push((id.clone(), medium));
            id
        });
        let covering = Covering { id: id.clone(), emitter, medium, uv_set, color_factor };
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
    wearer: Wearer,
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
    fn read(&mut self) -> Result<(Object, Option<Object>, Option<[f32; 3]>)> {
        let coloring = self.wearer.coloring;
        self.warn_of_textures();
        let metallic = self.material.pbr_metallic_roughness();
        let base_texture = self.info(metallic.base_color_texture());
        let mut base = BaseColor { factor: self.with_alpha(metallic.base_color_factor()), texture: base_texture };
        let (mut bsdf, transmits);
        let mut color_factor = None;
        if self.material.unlit() {
            let emitter = self.unlit(&base, &mut color_factor)?;
            let black = object(Kind::Bsdf, "diffuse", [("reflectance", color([0.0; 3]))]);
            self.warn("it is unlit (KHR_materials_unlit): it emits its color and reflects nothing");
            return Ok((self.masked(two_sided(black), &base)?, emitter, color_factor));
        }
        if let Some(specular) = self.material.pbr_specular_glossiness() {
            let diffuse = self.info(specular.diffuse_texture());
            let gloss = self.info(specular.specular_glossiness_texture());
            base = BaseColor { factor: self.with_alpha(specular.diffuse_factor()), texture: diffuse };
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
            bsdf = self.filmed(bsdf)?;
        }
        bsdf = self.with_normals(bsdf)?;
        // A dielectric body transmits from both sides already.
        let surface = if transmits { bsdf } else { two_sided(bsdf) };
        let surface = self.thin_transmission(surface, &base)?;
        let surface = self.diffuse_transmission(surface)?;
        let emitter = self.emitter(&base)?;
        Ok((self.masked(surface, &base)?, emitter, color_factor))
    }

    /// Factor of the base color with the alpha of the vertices' colors.
    fn with_alpha(&self, [red, green, blue, alpha]: [f32; 4]) -> [f32; 4] {
        [red, green, blue, alpha * f32::from_bits(self.wearer.alpha)]
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

    /// Puts a thin film over the part of the surface that has one.
    fn filmed(&mut self, bsdf: Object) -> Result<Object> {
        let Some(film) = film(&self.asset.document, self.material) else { return Ok(bsdf) };
        let (unit, byte) = film.thicknesses();
        let thickness = match film.thickness_texture.clone().map(|texture| self.keep(texture)) {
            Some(texture) => {
                let tag = format!("film{:08x}-{:08x}", film.thickness[0].to_bits(), film.thickness[1].to_bits());
                nested(scaled(self.images.numbers(&texture, &tag, byte)?, [unit; 3]))
            }
            None => number(film.thickness[1]),
        };
        let filmed = bsdf.clone().with("film_thickness", thickness).with("film_eta", number(film.eta));
        let texture = film.factor_texture.map(|texture| self.keep(texture));
        if film.factor == 1.0 && texture.is_none() {
            return Ok(filmed);
        }
        let share = self.number(texture.as_ref(), "film", film.factor, |texel| texel[0])?;
        Ok(object(Kind::Bsdf, "blendbsdf", [("weight", share), ("plain", nested(bsdf)), ("filmed", nested(filmed))]))
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
        volume::is_solid(self.material)
    }

    /// Adds the transmission of a body. Returns whether there is any.
    fn transmission(&mut self, bsdf: Object) -> Result<(Object, bool)> {
        if !self.is_solid() {
            return Ok((bsdf, false));
        }
        let Some(share) = self.transmitted()? else { return Ok((bsdf, false)) };
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
        if film(&self.asset.document, self.material).is_some() {
            self.warn("the sheet of a thin transmission has no film (KHR_materials_iridescence)");
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

    /// Mixes in what passes through diffusely. Nothing passes through metal.
    fn diffuse_transmission(&mut self, surface: Object) -> Result<Object> {
        let Some((share, sheet, has_textures)) = volume::diffuse_transmission(self.material) else {
            return Ok(surface);
        };
        if has_textures {
            self.warn("the textures of KHR_materials_diffuse_transmission are ignored");
        }
        let metallic = self.material.pbr_metallic_roughness();
        let has_metal = self.material.pbr_specular_glossiness().is_none();
        let metal = if has_metal { metallic.metallic_factor().clamp(0.0, 1.0) } else { 0.0 };
        let texture = self.info(metallic.metallic_roughness_texture().filter(|_| metal > 0.0));
        let factor = if texture.is_some() { share } else { share * (1.0 - metal) };
        let tag = format!("dielectric{:08x}", metal.to_bits());
        let weight =
            self.number(texture.as_ref(), &tag, factor, |texel| u8::MAX - (metal * f32::from(texel[2])).round() as u8)?;
        let parts = [("weight", weight), ("opaque", nested(surface)), ("sheet", nested(sheet))];
        Ok(object(Kind::Bsdf, "blendbsdf", parts))
    }

    fn with_normals(&mut self, bsdf: Object) -> Result<Object> {
        let Some(normals) = self.material.normal_texture() else { return Ok(bsdf) };
        let texture = self.keep(TextureUse::of_normals(&normals));
        let scale = normals.scale();
        let turned = self.wearer.turned;
        let bitmap = match scale == 1.0 && turned == [false; 2] {
            true => self.images.bitmap(&texture, Coding::Linear)?,
            false => {
                let scales = turned.map(|turned| if turned { -scale } else { scale });
                let slope =
                    |byte: u8, scale: f32| ((f32::from(byte) - 127.5) * scale + 127.5).round().clamp(0.0, 255.0) as u8;
                let tag = format!("normals{}_{}", scales[0], scales[1]);
                let scaled =
                    |texel: [u8; 4], _: f32, _: f32| [slope(texel[0], scales[0]), slope(texel[1], scales[1]), texel[2]];
                self.images.made(&texture, &tag, Coding::Linear, scaled)?
            }
        };
        Ok(object(Kind::Bsdf, "normalmap", [("normalmap", nested(bitmap)), ("surface", nested(bsdf))]))
    }

    /// Emitter of an unlit material, which emits its color.
    fn unlit(&mut self, base: &BaseColor<'a>, color_factor: &mut Option<[f32; 3]>) -> Result<Option<Object>> {
        let shown = self.color(base, self.wearer.coloring, color_factor)?;
        let opacity = Opacity::of(self.material, base);
        if let Some(factor) = color_factor {
            let scale = opacity.map_or(1.0, |opacity| opacity.scale());
            *factor = factor.map(|channel| channel * scale);
            return Ok(Some(object(Kind::Emitter, "area", [("radiance", shown)])));
        }
        let [red, green, blue, _] = base.factor;
        self.emission(base.texture.as_ref(), [red, green, blue], opacity.as_ref())
    }

    fn emission(
        &mut self,
        texture: Option<&TextureUse<'a>>,
        factor: [f32; 3],
        opacity: Option<&Opacity<'a>>,
    ) -> Result<Option<Object>> {
        let (asset, label) = (self.asset, &self.label);
        let warn = |message: &str| asset.warn(format!("{label}: {message}"));
        let radiance = radiance(self.images, texture, factor, opacity, warn)?;
        Ok(radiance.map(|radiance| object(Kind::Emitter, "area", [("radiance", radiance)])))
    }

    fn emitter(&mut self, base: &BaseColor<'a>) -> Result<Option<Object>> {
        let strength = self.material.emissive_strength().unwrap_or(1.0);
        let factor = self.material.emissive_factor().map(|channel| (channel * strength).max(0.0));
        let texture = self.info(self.material.emissive_texture());
        if factor == [0.0; 3] {
            return Ok(None);
        }
        if self.material.double_sided() {
            self.warn("it emits from its front only, though it is double-sided");
        }
        self.emission(texture.as_ref(), factor, Opacity::of(self.material, base).as_ref())
    }

    /// Surface with holes, where the alpha mode makes any.
    fn masked(&mut self, surface: Object, base: &BaseColor<'a>) -> Result<Object> {
        let Some(opacity) = Opacity::of(self.material, base) else { return Ok(surface) };
        let opacity = opacity.value(self.images)?;
        Ok(object(Kind::Bsdf, "mask", [("opacity", opacity), ("surface", nested(surface))]))
    }
}

fn material_label(material: &Material) -> String {
    match (material.name(), material.index()) {
        (Some(name), _) => format!("material `{name}`"),
        (None, Some(index)) => format!("material {index}"),
        (None, None) => "the default material".to_owned(),
    }
}
