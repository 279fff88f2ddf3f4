//! Materials to BSDFs and to the light that their surfaces emit.

use gltf::Material;
use gltf::material::AlphaMode;

use super::document::Model;
use super::entries::{number, object, rgb, set, text};
use super::textures::{Textures, Used};
use crate::Result;
use crate::scene::mitsuba::dictionary::{Dictionary, Value};

/// BSDF and emission of a material.
pub(super) struct Look {
    pub bsdf: Dictionary,
    /// Emission of the front, as an `area` emitter.
    pub emitter: Option<Dictionary>,
    /// Set of texture coordinates that the material's textures use.
    pub uv_set: u32,
}

/// Name of a material in messages, which is its key in the scene, too.
pub(super) fn key(material: &Material) -> String {
    match (material.index(), material.name()) {
        (Some(index), Some(name)) => format!("material {index} `{name}`"),
        (Some(index), None) => format!("material {index}"),
        (None, _) => "default material".to_owned(),
    }
}

/// Reader of one material.
struct Reader<'r, 'm> {
    model: &'m Model<'m>,
    textures: &'r mut Textures<'m>,
    what: String,
    uv_sets: Vec<u32>,
}

/// Reads a material. `has_colors` says whether meshes with it have colors of vertices.
pub(super) fn look<'m>(
    model: &'m Model<'m>,
    material: &Material,
    has_colors: bool,
    textures: &mut Textures<'m>,
) -> Result<Look> {
    let mut reader = Reader { model, textures, what: key(material), uv_sets: Vec::new() };
    let (bsdf, emitter) = if material.unlit() { reader.unlit(material, has_colors)? } else { reader.lit(material, has_colors)? };
    reader.uv_sets.sort_unstable();
    reader.uv_sets.dedup();
    if reader.uv_sets.len() > 1 {
        reader.warn("its textures use several sets of texture coordinates; the first is used for all");
    }
    let uv_set = reader.uv_sets.first().copied().unwrap_or(0);
    Ok(Look { bsdf, emitter, uv_set })
}

impl Reader<'_, '_> {
    fn warn(&mut self, message: &str) {
        self.textures.warnings.push(format!("{}: {}: {message}", self.model.path.display(), self.what));
    }

    fn use_texture(&mut self, used: &Used) {
        self.uv_sets.push(used.uv_set);
    }

    /// Color: a texture times a factor, or colors of vertices times a factor.
    fn color(&mut self, factor: [f32; 3], texture: Option<&Used>, has_colors: bool) -> Result<Value> {
        let nested = match texture {
            Some(used) => {
                self.use_texture(used);
                if has_colors {
                    self.warn("the colors of vertices are ignored, because a texture gives the color");
                }
                self.textures.color(used, &self.what)?
            }
            None if has_colors => object("mesh_attribute", [("name", text("vertex_color"))]),
            None => return Ok(rgb(factor)),
        };
        if factor == [1.0; 3] {
            return Ok(Value::Object(nested));
        }
        Ok(Value::Object(object("scale", [("scale", rgb(factor)), ("texture", Value::Object(nested))])))
    }

    /// Number: a factor times one channel of a texture.
    fn channel(&mut self, factor: f32, texture: Option<&Used>, channel: usize, role: &str) -> Result<Value> {
        let factor = factor.clamp(0.0, 1.0);
        let Some(used) = texture else { return Ok(number(factor)) };
        self.use_texture(used);
        let scaled = |byte: u8| (factor * f32::from(byte)).round() as u8;
        let gray = move |texel: [u8; 4]| [scaled(texel[channel]), scaled(texel[channel]), scaled(texel[channel]), 255];
        let key = format!("-{channel}-{factor}");
        self.textures.derived(used, role, &key, &self.what, gray).map(Value::Object)
    }

    fn unlit(&mut self, material: &Material, has_colors: bool) -> Result<(Dictionary, Option<Dictionary>)> {
        self.warn("it is unlit: its surface is black and emits its color from its front");
        let pbr = material.pbr_metallic_roughness();
        let texture = pbr.base_color_texture().map(Used::from);
        let [red, green, blue, alpha] = pbr.base_color_factor();
        let radiance = self.color([red, green, blue], texture.as_ref(), has_colors)?;
        let black = object("diffuse", [("reflectance", rgb([0.0; 3]))]);
        let bsdf = self.masked(black, material, alpha, texture.as_ref())?;
        Ok((bsdf, Some(object("area", [("radiance", radiance)]))))
    }

    fn lit(&mut self, material: &Material, has_colors: bool) -> Result<(Dictionary, Option<Dictionary>)> {
        let mut principled = object("principled", []);
        let (alpha, base) = match material.pbr_specular_glossiness() {
            Some(_) => self.specular_glossiness(material, has_colors, &mut principled)?,
            None => {
                let pbr = material.pbr_metallic_roughness();
                let base = pbr.base_color_texture().map(Used::from);
                let [red, green, blue, alpha] = pbr.base_color_factor();
                set(&mut principled, "base_color", self.color([red, green, blue], base.as_ref(), has_colors)?);
                let packed = pbr.metallic_roughness_texture().map(Used::from);
                let roughness = self.channel(pbr.roughness_factor(), packed.as_ref(), 1, "roughness")?;
                set(&mut principled, "roughness", roughness);
                let metallic = self.channel(pbr.metallic_factor(), packed.as_ref(), 2, "metallic")?;
                set(&mut principled, "metallic", metallic);
                (alpha, base)
            }
        };
        if material.pbr_specular_glossiness().is_none() {
            set(&mut principled, "eta", number(self.index(material)));
        }
        let transmits = self.transmission(material, &mut principled)?;
        self.clearcoat(material, &mut principled);
        self.sheen(material, &mut principled);
        let mut bsdf = principled;
        if let Some(map) = material.normal_texture() {
            bsdf = self.normal_map(&map, bsdf)?;
        }
        // A path tracer shows backs, too. `twosided` takes no material that transmits.
        if !transmits {
            bsdf = object("twosided", [("bsdf", Value::Object(bsdf))]);
        }
        let bsdf = self.masked(bsdf, material, alpha, base.as_ref())?;
        Ok((bsdf, self.emission(material)?))
    }

    /// Index of refraction, with the strength of KHR_materials_specular in it.
    fn index(&mut self, material: &Material) -> f32 {
        let eta = material.ior().unwrap_or(1.5).max(1.0);
        let Some(specular) = material.specular() else { return eta };
        if specular.specular_texture().is_some() || specular.specular_color_texture().is_some() {
            self.warn("the textures of KHR_materials_specular are ignored");
        }
        let color = specular.specular_color_factor();
        if color.iter().any(|&channel| channel != color[0]) {
            self.warn("the color of KHR_materials_specular is reduced to its mean");
        }
        let reflectance = ((eta - 1.0) / (eta + 1.0)).powi(2) * specular.specular_factor() * color.iter().sum::<f32>() / 3.0;
        index_of(reflectance)
    }

    fn transmission(&mut self, material: &Material, principled: &mut Dictionary) -> Result<bool> {
        if let Some(volume) = material.volume()
            && volume.attenuation_distance().is_finite()
            && volume.attenuation_color() != [1.0; 3]
        {
            self.warn("the color of KHR_materials_volume is ignored: nothing is absorbed inside");
        }
        let Some(transmission) = material.transmission() else { return Ok(false) };
        let texture = transmission.transmission_texture().map(Used::from);
        let share = self.channel(transmission.transmission_factor(), texture.as_ref(), 0, "transmission")?;
        let transmits = texture.is_some() || transmission.transmission_factor() > 0.0;
        set(principled, "spec_trans", share);
        if transmits && material.volume().is_none_or(|volume| volume.thickness_factor() == 0.0) {
            self.warn("its surface is thin by KHR_materials_transmission, but refracts as a solid body");
        }
        Ok(transmits)
    }

    fn clearcoat(&mut self, material: &Material, principled: &mut Dictionary) {
        let Some(coat) = material.extension_value("KHR_materials_clearcoat") else { return };
        let factor = |name: &str| coat.get(name).and_then(|value| value.as_f64()).unwrap_or(0.0).clamp(0.0, 1.0) as f32;
        if ["clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"].iter().any(|name| coat.get(name).is_some()) {
            self.warn("the textures of KHR_materials_clearcoat are ignored");
        }
        set(principled, "clearcoat", number(factor("clearcoatFactor")));
        set(principled, "clearcoat_gloss", number(1.0 - factor("clearcoatRoughnessFactor")));
    }

    fn sheen(&mut self, material: &Material, principled: &mut Dictionary) {
        let Some(sheen) = material.extension_value("KHR_materials_sheen") else { return };
        let channel = |index: usize| sheen.get("sheenColorFactor")?.get(index)?.as_f64();
        let largest = (0..3).filter_map(channel).fold(0.0, f64::max).clamp(0.0, 1.0) as f32;
        if largest > 0.0 {
            self.warn("KHR_materials_sheen is approximated by the sheen of `principled`: its roughness and color are ignored");
            set(principled, "sheen", number(largest));
        }
    }

    /// Reads KHR_materials_pbrSpecularGlossiness; returns the factor of alpha and the texture of colors.
    fn specular_glossiness<'a>(
        &mut self,
        material: &Material<'a>,
        has_colors: bool,
        principled: &mut Dictionary,
    ) -> Result<(f32, Option<Used<'a>>)> {
        let Some(gloss) = material.pbr_specular_glossiness() else { return Ok((1.0, None)) };
        let [red, green, blue, alpha] = gloss.diffuse_factor();
        let base = gloss.diffuse_texture().map(Used::from);
        let specular = gloss.specular_factor();
        let largest = specular.iter().copied().fold(0.0, f32::max);
        let is_metal = base.is_none() && largest > red.max(green).max(blue) && largest > 0.2;
        if gloss.specular_glossiness_texture().is_some() {
            self.warn("the specular and glossiness texture is ignored; its factors are used");
        }
        let color = if is_metal { specular } else { [red, green, blue] };
        set(principled, "base_color", self.color(color, base.as_ref(), has_colors)?);
        set(principled, "metallic", number(if is_metal { 1.0 } else { 0.0 }));
        set(principled, "roughness", number((1.0 - gloss.glossiness_factor()).clamp(0.0, 1.0)));
        // A dielectric with a specular factor of 1 would be a mirror: its textures usually darken it.
        let reflectance = if gloss.specular_glossiness_texture().is_some() { 0.04 } else { largest.min(0.2) };
        set(principled, "eta", number(index_of(reflectance)));
        Ok((alpha, base))
    }

    fn normal_map(&mut self, map: &gltf::material::NormalTexture, bsdf: Dictionary) -> Result<Dictionary> {
        if map.extension_value("KHR_texture_transform").is_some() {
            self.warn("the KHR_texture_transform of its normal map is ignored");
        }
        let used = Used { texture: map.texture(), transform: None, uv_set: map.tex_coord() };
        self.use_texture(&used);
        let scale = map.scale();
        // The green channel points up in the image; `v` points down.
        let turned = move |[red, green, blue, alpha]: [u8; 4]| {
            if scale == 1.0 {
                return [red, 255 - green, blue, alpha];
            }
            let [x, y, z] = [red, 255 - green, blue].map(|byte| f32::from(byte) / 127.5 - 1.0);
            let normal = glam::Vec3::new(scale * x, scale * y, z).normalize_or(glam::Vec3::Z);
            let [x, y, z] = normal.to_array().map(|c| (127.5 * (c + 1.0)).round() as u8);
            [x, y, z, alpha]
        };
        let bitmap = self.textures.derived(&used, "normal", &format!("-{scale}"), &self.what, turned)?;
        Ok(object("normalmap", [("normalmap", Value::Object(bitmap)), ("bsdf", Value::Object(bsdf))]))
    }

    fn emission(&mut self, material: &Material) -> Result<Option<Dictionary>> {
        let strength = material.emissive_strength().unwrap_or(1.0);
        let factor = material.emissive_factor().map(|channel| (channel * strength).max(0.0));
        if factor == [0.0; 3] {
            return Ok(None);
        }
        let texture = material.emissive_texture().map(Used::from);
        if material.double_sided() {
            self.warn("it is double-sided, but emits from its front only");
        }
        let radiance = self.color(factor, texture.as_ref(), false)?;
        Ok(Some(object("area", [("radiance", radiance)])))
    }

    /// Puts a mask around the BSDF where the material is not opaque.
    fn masked(&mut self, bsdf: Dictionary, material: &Material, alpha: f32, base: Option<&Used>) -> Result<Dictionary> {
        let base = match base {
            Some(used) if self.textures.has_alpha(used, &self.what)? => Some(used),
            _ => None,
        };
        let opacity = match (material.alpha_mode(), base) {
            (AlphaMode::Opaque, _) => return Ok(bsdf),
            (AlphaMode::Blend, None) if alpha >= 1.0 => return Ok(bsdf),
            (AlphaMode::Blend, _) => self.channel(alpha, base, 3, "opacity")?,
            (AlphaMode::Mask, None) => {
                let is_there = alpha >= material.alpha_cutoff().unwrap_or(0.5);
                if is_there {
                    return Ok(bsdf);
                }
                number(0.0)
            }
            (AlphaMode::Mask, Some(used)) => {
                let cutoff = material.alpha_cutoff().unwrap_or(0.5);
                let cut = move |texel: [u8; 4]| {
                    let opacity = if alpha * f32::from(texel[3]) / 255.0 >= cutoff { 255 } else { 0 };
                    [opacity, opacity, opacity, 255]
                };
                self.use_texture(used);
                Value::Object(self.textures.derived(used, "mask", &format!("-{cutoff}-{alpha}"), &self.what, cut)?)
            }
        };
        Ok(object("mask", [("opacity", opacity), ("bsdf", Value::Object(bsdf))]))
    }
}

/// Index of refraction that reflects this share at normal incidence.
fn index_of(reflectance: f32) -> f32 {
    let root = reflectance.clamp(0.0, 0.9).sqrt();
    ((1.0 + root) / (1.0 - root)).max(1.0)
}
