//! Images and textures (`UsdUVTexture`).

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, DVec4, dvec2};
use openusd::sdf;
use openusd::sdf::Value as UsdValue;

use super::asset::{Asset, Prim};
use super::budget::Texels;
use super::values;
use crate::Result;
use crate::image::texels::{self, FileTexels, TexelImage};
use crate::image::tone::srgb;
use crate::math::srgb::linear_from_srgb;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, matrix, nested, object};
use crate::scene::description::object::{ImageFile, Object, Value};

/// Longest chain of nodes that transform texture coordinates.
const MOST_NODES: usize = 16;

/// What the image of a texture means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ColorSpace {
    Raw,
    Srgb,
    /// The curve of sRGB for images of 8 bits and three or four channels.
    Auto,
}

/// A `UsdUVTexture`, as an input of a surface uses it.
#[derive(Clone)]
pub(super) struct Texture {
    /// Path of the shader.
    prim: sdf::Path,
    /// Resolved path of the image.
    path: String,
    /// Name of the primvar of texture coordinates.
    pub primvar: String,
    to_uv: DMat3,
    wrap: &'static str,
    space: ColorSpace,
    scale: [f64; 4],
    bias: [f64; 4],
    /// Name of the output, such as `rgb` or `r`.
    output: String,
}

/// What a `UsdUVTexture` amounts to.
pub(super) enum Source {
    Texture(Box<Texture>),
    /// Its fallback, because the image cannot be found.
    Constant([f64; 4]),
}

impl Texture {
    /// The texture of a `UsdUVTexture` by its output.
    pub fn of(shader: &Prim, output: &str) -> Result<Source> {
        let asset = shader.asset;
        let four =
            |name: &str, default| -> Result<[f64; 4]> { Ok(input(shader, name, values::four)?.unwrap_or(default)) };
        let fallback: [f64; 4] = four("inputs:fallback", [0.0, 0.0, 0.0, 1.0])?;
        let (holder, name) = followed(shader, "inputs:file")?;
        let file = holder.value(&name)?;
        let Some(path) = file.as_ref().and_then(|file| resolved(asset, file)) else {
            let name = file.as_ref().and_then(values::text).unwrap_or_default();
            let message = match name.contains("<UDIM>") || name.contains("<udim>") {
                true => "images in tiles (UDIM) are not read; its fallback is used".to_owned(),
                false if name.is_empty() => "it names no image; its fallback is used".to_owned(),
                false => format!("its image is missing ({}); its fallback is used", crate::quoted::word(&name)),
            };
            asset.warn_of(&shader.path, message);
            return Ok(Source::Constant(fallback));
        };
        let (primvar, to_st) = coordinates(shader)?;
        let wrap = |name: &str| -> Result<String> {
            Ok(input(shader, name, values::text)?.unwrap_or("useMetadata".to_owned()))
        };
        let (wrap_s, wrap_t): (String, String) = (wrap("inputs:wrapS")?, wrap("inputs:wrapT")?);
        let mode = |wrap: &str| match wrap {
            "clamp" | "black" => "clamp",
            "mirror" => "mirror",
            _ => "repeat",
        };
        if mode(&wrap_s) != mode(&wrap_t) {
            let message = format!("it has the wrap modes `{wrap_s}` and `{wrap_t}`; `{wrap_s}` is used for both");
            asset.warn_of(&shader.path, message);
        }
        if wrap_s == "black" || wrap_t == "black" {
            asset.warn_of(&shader.path, "the wrap mode `black` is rendered as `clamp`");
        }
        let space = match input(shader, "inputs:sourceColorSpace", values::text)?.as_deref() {
            Some("raw") => ColorSpace::Raw,
            Some("sRGB") => ColorSpace::Srgb,
            _ => ColorSpace::Auto,
        };
        // USD's t points up in the image, Lodestar's v down.
        let turned = DMat3::from_translation(dvec2(0.0, 1.0)) * DMat3::from_scale(dvec2(1.0, -1.0));
        Ok(Source::Texture(Box::new(Self {
            prim: shader.path.clone(),
            path,
            primvar,
            to_uv: turned * to_st * turned,
            wrap: mode(&wrap_s),
            space,
            scale: four("inputs:scale", [1.0; 4])?,
            bias: four("inputs:bias", [0.0; 4])?,
            output: output.strip_prefix("outputs:").unwrap_or(output).to_owned(),
        })))
    }

    /// Index of the channel that is a number; `None` for a color.
    fn channel(&self) -> Option<usize> {
        match &*self.output {
            "r" => Some(0),
            "g" => Some(1),
            "b" => Some(2),
            "a" => Some(3),
            _ => None,
        }
    }
}

/// Resolved path of a file that an attribute names; `None` where there is none.
pub(super) fn resolved(asset: &Asset, file: &UsdValue) -> Option<String> {
    let UsdValue::AssetPath(path) = file else { return None };
    let found = path.resolved_path().map(str::to_owned);
    // An absolute path needs no place from which it is searched.
    found.or_else(|| {
        let resolved = openusd::ar::Resolver::resolve(&asset.files, path.asset_path())?;
        Path::new(path.asset_path()).is_absolute().then(|| resolved.to_string())
    })
}

/// The prim and the name of the attribute that gives an input its value, along connections.
pub(super) fn followed<'a>(shader: &Prim<'a>, name: &str) -> Result<(Prim<'a>, String)> {
    let (mut prim, mut name) = (shader.clone(), name.to_owned());
    for _ in 0..MOST_NODES {
        let Some((next, property)) = prim.connection(&name)? else { break };
        prim = prim.asset.prim(&next)?;
        name = property;
    }
    Ok((prim, name))
}

/// Value of an input, along connections.
fn input<T>(shader: &Prim, name: &str, of: impl Fn(&UsdValue) -> Option<T>) -> Result<Option<T>> {
    let (holder, name) = followed(shader, name)?;
    holder.read(&name, of)
}

/// Name of the primvar that a texture's `st` reads, and the transform of its values.
fn coordinates(shader: &Prim) -> Result<(String, DMat3)> {
    let asset = shader.asset;
    let mut to_st = DMat3::IDENTITY;
    let (mut node, _) = followed(shader, "inputs:st")?;
    for _ in 0..MOST_NODES {
        if node.path == shader.path {
            break;
        }
        let id = node.text("info:id")?.unwrap_or_default();
        if id.starts_with("UsdPrimvarReader") {
            let (holder, name) = followed(&node, "inputs:varname")?;
            let primvar = holder.text(&name)?.unwrap_or_else(|| "st".to_owned());
            return Ok((primvar, to_st));
        }
        if id != "UsdTransform2d" {
            asset.warn_of(&node.path, format!("the node `{id}` of texture coordinates is not known; `st` is used"));
            break;
        }
        let pair = |name: &str, default: [f64; 2]| -> Result<[f64; 2]> {
            Ok(input(&node, name, values::pairs)?.and_then(|list| list.first().copied()).unwrap_or(default))
        };
        let [scale, offset]: [[f64; 2]; 2] = [pair("inputs:scale", [1.0; 2])?, pair("inputs:translation", [0.0; 2])?];
        let angle = input(&node, "inputs:rotation", values::number)?.filter(|angle| angle.is_finite()).unwrap_or(0.0);
        let angle = angle.to_radians();
        let own = DMat3::from_translation(offset.into()) * DMat3::from_angle(angle) * DMat3::from_scale(scale.into());
        to_st *= own;
        let (next, _) = followed(&node, "inputs:in")?;
        if next.path == node.path {
            break;
        }
        node = next;
    }
    Ok(("st".to_owned(), to_st))
}

/// Images that textures use.
#[derive(Default)]
pub(super) struct Images {
    decoded: HashMap<String, Rc<TexelImage>>,
    /// Paths of decoded images that have fewer than three channels.
    gray: HashSet<String>,
    /// Images in memory, by name.
    files: HashMap<String, Arc<[u8]>>,
    /// Name of each image of an archive, by its path.
    names: HashMap<String, String>,
    budget: Texels,
}

impl Images {
    /// Texture of colors.
    pub fn color(&mut self, asset: &Asset, texture: &Texture) -> Result<Object> {
        let [scale, bias] = [texture.scale, texture.bias].map(|list| [list[0], list[1], list[2]]);
        let is_plain = texture.channel().is_none() && bias == [0.0; 3] && scale.iter().all(|&factor| factor >= 0.0);
        if !is_plain {
            let texels = |texel: [f64; 4]| {
                let encoded = |channel: f64| (srgb(channel.clamp(0.0, 1.0)) * 255.0).round() as u8;
                colored(texture, texel).map(encoded)
            };
            return self.made(asset, texture, "color", false, texels);
        }
        let is_raw = self.is_raw(asset, texture)?;
        let name = self.name(asset, texture)?;
        Ok(scaled(self.bitmap(texture, name, is_raw), scale.map(|channel| channel as f32)))
    }

    /// Texture of numbers, which `to` changes.
    pub fn numbers(&mut self, asset: &Asset, texture: &Texture, tag: &str, to: impl Fn(f64) -> f64) -> Result<Object> {
        self.made(asset, texture, tag, true, |texel| {
            [(to(numbered(texture, texel)).clamp(0.0, 1.0) * 255.0).round() as u8; 3]
        })
    }

    /// Texture of directions for a `normalmap`.
    pub fn normals(&mut self, asset: &Asset, texture: &Texture) -> Result<Object> {
        let is_usual = texture.scale[..3] == [2.0; 3] && texture.bias[..3] == [-1.0; 3];
        if is_usual && self.is_raw(asset, texture)? {
            let name = self.name(asset, texture)?;
            return Ok(self.bitmap(texture, name, true));
        }
        self.made(asset, texture, "normals", true, |texel| {
            colored(texture, texel).map(|channel| ((0.5 * channel + 0.5).clamp(0.0, 1.0) * 255.0).round() as u8)
        })
    }

    /// Mean of the colors of a texture.
    pub fn mean(&mut self, asset: &Asset, texture: &Texture) -> Result<[f64; 3]> {
        let is_raw = self.is_raw(asset, texture)?;
        let image = self.decode(asset, texture)?;
        let count = image.width as usize * image.height as usize;
        let mut sum = DVec3::ZERO;
        for at in 0..count {
            sum += DVec3::from_array(colored(texture, texel(&image, at, is_raw)));
        }
        Ok((sum / count.max(1) as f64).to_array())
    }

    /// Texture made texel by texel. `tag` tells apart what is made of one image.
    fn made(
        &mut self,
        asset: &Asset,
        texture: &Texture,
        tag: &str,
        raw: bool,
        color: impl Fn([f64; 4]) -> [u8; 3],
    ) -> Result<Object> {
        let is_raw = self.is_raw(asset, texture)?;
        let key = format!("{}|{tag}|{}|{:?}|{:?}|{is_raw}", texture.path, texture.output, texture.scale, texture.bias);
        let name = match self.names.get(&key) {
            Some(name) => name.clone(),
            None => {
                let image = self.decode(asset, texture)?;
                self.budget.take(&image).map_err(|message| asset.prim_error(&texture.prim, message))?;
                let count = image.width as usize * image.height as usize;
                let texels: Vec<[u8; 4]> = (0..count)
                    .map(|at| {
                        let [r, g, b] = color(texel(&image, at, is_raw));
                        [r, g, b, u8::MAX]
                    })
                    .collect();
                let name = format!("image{}-{tag}.png", self.names.len());
                let png = texels::encode_png(Path::new(&name), image.width, image.height, &texels)?;
                self.files.insert(name.clone(), png.into());
                self.names.insert(key, name.clone());
                name
            }
        };
        Ok(self.bitmap(texture, name, raw))
    }

    /// Name by which a `bitmap` finds the image. Images of an archive become files in memory.
    pub fn name_of(&mut self, asset: &Asset, prim: &sdf::Path, path: &str) -> Result<Value> {
        if !openusd::ar::is_package_relative_path(path) {
            return Ok(Value::Text(path.to_owned()));
        }
        let name = match self.names.get(path) {
            Some(name) => name.clone(),
            None => {
                let bytes = asset.files.bytes(path).map_err(|error| asset.fault(prim, &error))?;
                let extension = path.trim_end_matches(']').rsplit_once('.').map_or("image", |(_, extension)| extension);
                let name = format!("image{}.{extension}", self.names.len());
                self.files.insert(name.clone(), bytes.into());
                self.names.insert(path.to_owned(), name.clone());
                name
            }
        };
        Ok(self.file(name))
    }

    fn file(&self, name: String) -> Value {
        match self.files.get(&name) {
            Some(bytes) => Value::Image(ImageFile { name, bytes: Arc::clone(bytes) }),
            None => Value::Text(name),
        }
    }

    fn name(&mut self, asset: &Asset, texture: &Texture) -> Result<String> {
        Ok(match self.name_of(asset, &texture.prim, &texture.path)? {
            Value::Image(file) => file.name,
            _ => texture.path.clone(),
        })
    }

    /// Whether the numbers of the image are linear.
    fn is_raw(&mut self, asset: &Asset, texture: &Texture) -> Result<bool> {
        Ok(match texture.space {
            ColorSpace::Raw => true,
            ColorSpace::Srgb => false,
            ColorSpace::Auto => {
                let is_bytes = matches!(self.decode(asset, texture)?.texels, FileTexels::Bytes(_));
                !is_bytes || self.gray.contains(&texture.path)
            }
        })
    }

    fn decode(&mut self, asset: &Asset, texture: &Texture) -> Result<Rc<TexelImage>> {
        if let Some(decoded) = self.decoded.get(&texture.path) {
            return Ok(Rc::clone(decoded));
        }
        let fault = |error: &dyn std::fmt::Display| asset.prim_error(&texture.prim, error);
        let bytes = asset.files.bytes(&texture.path).map_err(|error| fault(&error))?;
        // The extension of a file in an archive tells its format.
        let name = Path::new(texture.path.trim_end_matches(']'));
        let decoded = Rc::new(texels::decode(name, &bytes).map_err(|error| fault(&error))?);
        self.budget.take(&decoded).map_err(|message| fault(&message))?;
        if texels::channels(&bytes).is_some_and(|count| count < 3) {
            self.gray.insert(texture.path.clone());
        }
        self.decoded.insert(texture.path.clone(), Rc::clone(&decoded));
        Ok(decoded)
    }

    fn bitmap(&self, texture: &Texture, name: String, raw: bool) -> Object {
        let entries = [
            ("filename", self.file(name)),
            ("raw", Value::Boolean(raw)),
            ("wrap_mode", Value::Text(texture.wrap.into())),
        ];
        let bitmap = object(Kind::Texture, "bitmap", entries);
        if texture.to_uv == DMat3::IDENTITY {
            return bitmap;
        }
        let column = |column: DVec3| column.truncate().extend(0.0).extend(0.0);
        let last = texture.to_uv.z_axis.truncate().extend(0.0).extend(1.0);
        let columns = DMat4::from_cols(column(texture.to_uv.x_axis), column(texture.to_uv.y_axis), DVec4::Z, last);
        bitmap.with("to_uv", matrix(&columns))
    }
}

/// Color that a texture makes of a linear texel.
fn colored(texture: &Texture, texel: [f64; 4]) -> [f64; 3] {
    match texture.channel() {
        Some(_) => [numbered(texture, texel); 3],
        None => std::array::from_fn(|channel| texel[channel] * texture.scale[channel] + texture.bias[channel]),
    }
}

/// Number that a texture makes of a linear texel.
fn numbered(texture: &Texture, texel: [f64; 4]) -> f64 {
    let channel = texture.channel().unwrap_or(0);
    texel[channel] * texture.scale[channel] + texture.bias[channel]
}

/// Texel in linear numbers.
fn texel(image: &TexelImage, at: usize, is_raw: bool) -> [f64; 4] {
    let (texel, is_encoded) = match &image.texels {
        FileTexels::Bytes(data) => (data[at].map(|channel| f64::from(channel) / 255.0), true),
        FileTexels::Encoded(data) => (data[at].map(f64::from), true),
        FileTexels::Linear(data) => (data[at].map(f64::from), false),
    };
    let [red, green, blue, alpha] = texel;
    if is_raw || !is_encoded {
        return texel;
    }
    let [red, green, blue] = [red, green, blue].map(linear_from_srgb);
    [red, green, blue, alpha]
}

/// Texture multiplied by a color.
pub(super) fn scaled(texture: Object, factor: [f32; 3]) -> Object {
    match factor == [1.0; 3] {
        true => texture,
        false => object(Kind::Texture, "scale", [("scale", color(factor)), ("texture", nested(texture))]),
    }
}
