//! Images and textures.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, dvec2};
use gltf::image::Source;
use gltf::texture::{MagFilter, WrappingMode};
use serde_json::Value as Json;

use super::asset::Asset;
use super::budget::Budget;
use super::buffers::{self, data_uri};
use crate::Result;
use crate::image::texels::{self, FileTexels, TexelImage};
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{color, matrix, nested, object};
use crate::scene::description::object::{ImageFile, Object, Value};

/// Use of a texture by a material.
#[derive(Clone)]
pub(super) struct TextureUse<'a> {
    texture: gltf::Texture<'a>,
    /// Set of texture coordinates.
    pub uv_set: u32,
    /// `KHR_texture_transform`, where it is given.
    to_uv: Option<DMat3>,
}

impl<'a> TextureUse<'a> {
    /// Use of a texture with its transform.
    pub fn of(info: &gltf::texture::Info<'a>) -> Self {
        let transform = info.texture_transform();
        let to_uv = transform.as_ref().map(|transform| {
            to_uv(transform.offset().map(f64::from), f64::from(transform.rotation()), transform.scale().map(f64::from))
        });
        let own_set = transform.and_then(|transform| transform.tex_coord());
        Self { texture: info.texture(), uv_set: own_set.unwrap_or(info.tex_coord()), to_uv }
    }

    /// Use of a normal map.
    pub fn of_normals(info: &gltf::material::NormalTexture<'a>) -> Self {
        Self::placed(info.texture(), info.tex_coord(), info.extension_value("KHR_texture_transform"))
    }

    /// Use of a texture by an extension that is read as JSON; `None` where the model has no such texture.
    pub fn of_json(document: &'a gltf::Document, info: &Json) -> Option<Self> {
        let texture = document.textures().nth(usize::try_from(info.get("index")?.as_u64()?).ok()?)?;
        let uv_set = info.get("texCoord").and_then(Json::as_u64).unwrap_or(0);
        let transform = info.get("extensions").and_then(|extensions| extensions.get("KHR_texture_transform"));
        Some(Self::placed(texture, uv_set as u32, transform))
    }

    fn placed(texture: gltf::Texture<'a>, uv_set: u32, transform: Option<&Json>) -> Self {
        let pair = |name: &str, default: f64| {
            let list = transform.and_then(|transform| transform.get(name)?.as_array());
            [0, 1].map(|at| list.and_then(|list| list.get(at)?.as_f64()).unwrap_or(default))
        };
        let rotation = transform.and_then(|transform| transform.get("rotation")?.as_f64()).unwrap_or(0.0);
        let own_set = transform.and_then(|transform| transform.get("texCoord").and_then(Json::as_u64));
        Self {
            texture,
            uv_set: own_set.map_or(uv_set, |set| set as u32),
            to_uv: transform.map(|_| to_uv(pair("offset", 0.0), rotation, pair("scale", 1.0))),
        }
    }

    /// Whether the texels of both lie at the same places of a surface.
    pub fn lies_as(&self, other: &Self) -> bool {
        let wraps = |texture: &gltf::Texture| (texture.sampler().wrap_s(), texture.sampler().wrap_t());
        self.uv_set == other.uv_set && self.to_uv == other.to_uv && wraps(&self.texture) == wraps(&other.texture)
    }
}

/// Base color of a material, with alpha.
pub(super) struct BaseColor<'a> {
    pub factor: [f32; 4],
    pub texture: Option<TextureUse<'a>>,
}

/// Matrix of `KHR_texture_transform`: scale, then rotation, then offset. An angle of a quarter turn takes (0, 1) to (1, 0), as in
/// Blender's reader.
fn to_uv(offset: [f64; 2], rotation: f64, scale: [f64; 2]) -> DMat3 {
    let translation = DMat3::from_translation(dvec2(offset[0], offset[1]));
    translation * DMat3::from_angle(-rotation) * DMat3::from_scale(dvec2(scale[0], scale[1]))
}

/// Meaning of an image's bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    /// Colors by the sRGB curve.
    Srgb,
    /// Numbers.
    Linear,
}

/// Images that textures use, those of the file and those made from them.
pub(super) struct Images<'a> {
    asset: &'a Asset,
    /// Names of the image files that the model names.
    beside: HashSet<String>,
    /// Name of each image by its index.
    names: HashMap<usize, String>,
    decoded: HashMap<usize, Rc<TexelImage>>,
    /// Images in memory, by name.
    files: HashMap<String, Arc<[u8]>>,
    budget: Budget,
}

impl<'a> Images<'a> {
    pub fn new(asset: &'a Asset) -> Self {
        let name = |image: gltf::Image| match image.source() {
            Source::Uri { uri, .. } if !uri.starts_with("data:") => buffers::file_name(&asset.path, uri).ok(),
            _ => None,
        };
        Self {
            asset,
            beside: asset.document.images().filter_map(name).collect(),
            names: HashMap::new(),
            decoded: HashMap::new(),
            files: HashMap::new(),
            budget: Budget::default(),
        }
    }

    /// Texture of an image as it is.
    pub fn bitmap(&mut self, texture: &TextureUse<'a>, coding: Coding) -> Result<Object> {
        let image = self.image(texture)?;
        let name = self.name(&image)?;
        Ok(self.texture(texture, name, coding))
    }

    /// Texture of numbers, one for each texel, made from an image's bytes red, green, blue and alpha. `tag` tells textures that are
    /// made from one image apart.
    pub fn numbers(&mut self, texture: &TextureUse<'a>, tag: &str, number: impl Fn([u8; 4]) -> u8) -> Result<Object> {
        self.made(texture, tag, Coding::Linear, |texel, _, _| [number(texel); 3])
    }

    /// Texture of colors made from an image's texels, of which `color` also learns the place in the unit square. `tag` tells apart
    /// what is made from one image, so it has every other fact that `color` depends on.
    pub fn made(
        &mut self,
        texture: &TextureUse<'a>,
        tag: &str,
        coding: Coding,
        color: impl Fn([u8; 4], f32, f32) -> [u8; 3],
    ) -> Result<Object> {
        let source = self.image(texture)?;
        let name = self.new_name(&format!("image{}-{tag}", source.index()), "png");
        if !self.files.contains_key(&name) {
            let image = self.decode(&source)?;
            self.take(&image)?;
            let (width, height) = (image.width as usize, image.height as usize);
            let place = |at: usize, count: usize| (at as f32 + 0.5) / count as f32;
            let texels = (0..width * height)
                .map(|at| {
                    let [r, g, b] = color(texel(&image, at), place(at % width, width), place(at / width, height));
                    [r, g, b, u8::MAX]
                })
                .collect::<Vec<_>>();
            let png = texels::encode_png(Path::new(&name), image.width, image.height, &texels)?;
            self.files.insert(name.clone(), png.into());
        }
        Ok(self.texture(texture, name, coding))
    }

    /// Decoded image of a texture.
    pub fn texels(&mut self, texture: &TextureUse<'a>) -> Result<Rc<TexelImage>> {
        let image = self.image(texture)?;
        self.decode(&image)
    }

    /// Image of a texture.
    pub fn image(&self, texture: &TextureUse<'a>) -> Result<gltf::Image<'a>> {
        let texture = &texture.texture;
        let by_extension = || {
            let index = |name| texture.extension_value(name)?.get("source")?.as_u64();
            let index = ["EXT_texture_webp", "KHR_texture_basisu"].into_iter().find_map(index)?;
            self.asset.document.images().nth(index as usize)
        };
        texture.source().or_else(by_extension).ok_or_else(|| {
            let what = match texture.extension_value("EXT_texture_avif") {
                Some(_) => "has an AVIF image (EXT_texture_avif), which is not read",
                None => "has no image",
            };
            self.asset
                .error(format!("texture {} {what}; save it with a PNG, JPEG, WebP or KTX2 image", texture.index()))
        })
    }

    /// Name by which a `bitmap` finds the image. Images within the file become files in memory.
    fn name(&mut self, image: &gltf::Image<'a>) -> Result<String> {
        if let Some(name) = self.names.get(&image.index()) {
            return Ok(name.clone());
        }
        let name = match image.source() {
            Source::Uri { uri, .. } if data_uri(uri).is_none() => buffers::file_name(&self.asset.path, uri)?,
            _ => {
                let content = self.content(image)?;
                let name = self.new_name(&format!("image{}", image.index()), extension(&content));
                self.files.insert(name.clone(), content.into());
                name
            }
        };
        self.names.insert(image.index(), name.clone());
        Ok(name)
    }

    /// Name for an image in memory. No image file that the model names has it, because images in memory are found first.
    fn new_name(&self, stem: &str, extension: &str) -> String {
        let mut name = format!("{stem}.{extension}");
        while self.beside.contains(&name) {
            name.insert(0, '_');
        }
        name
    }

    fn content(&self, image: &gltf::Image) -> Result<Vec<u8>> {
        match image.source() {
            Source::Uri { uri, .. } => self.asset.uri(uri),
            Source::View { view, .. } => Ok(self.asset.view(&view)?.to_vec()),
        }
    }

    fn decode(&mut self, image: &gltf::Image) -> Result<Rc<TexelImage>> {
        if let Some(decoded) = self.decoded.get(&image.index()) {
            return Ok(Rc::clone(decoded));
        }
        let name = format!("{}: image{}", self.asset.path.display(), image.index());
        let decoded = Rc::new(texels::decode(Path::new(&name), &self.content(image)?)?);
        self.take(&decoded)?;
        self.decoded.insert(image.index(), Rc::clone(&decoded));
        Ok(decoded)
    }

    /// Takes an image's texels from those that may be made.
    fn take(&mut self, image: &TexelImage) -> Result<()> {
        self.budget.take(image).map_err(|message| self.asset.error(message))
    }

    fn texture(&self, texture: &TextureUse, name: String, coding: Coding) -> Object {
        let sampler = texture.texture.sampler();
        let wrap = |mode| match mode {
            WrappingMode::ClampToEdge => "clamp",
            WrappingMode::MirroredRepeat => "mirror",
            WrappingMode::Repeat => "repeat",
        };
        if sampler.wrap_s() != sampler.wrap_t() {
            let (s, t) = (wrap(sampler.wrap_s()), wrap(sampler.wrap_t()));
            let index = texture.texture.index();
            self.asset.warn(format!("texture {index} has the wrap modes `{s}` and `{t}`; `{s}` is used for both"));
        }
        let filter = if sampler.mag_filter() == Some(MagFilter::Nearest) { "nearest" } else { "bilinear" };
        let file = match self.files.get(&name) {
            Some(bytes) => Value::Image(ImageFile { name, bytes: Arc::clone(bytes) }),
            None => Value::Text(name),
        };
        let entries = [
            ("filename", file),
            ("raw", Value::Boolean(coding == Coding::Linear)),
            ("wrap_mode", Value::Text(wrap(sampler.wrap_s()).into())),
            ("filter_type", Value::Text(filter.into())),
        ];
        let bitmap = object(Kind::Texture, "bitmap", entries);
        match texture.to_uv {
            None => bitmap,
            Some(to_uv) => {
                let [x, y, w] = [to_uv.x_axis, to_uv.y_axis, to_uv.z_axis];
                let column = |column: DVec3| column.truncate().extend(0.0).extend(0.0);
                let last = w.truncate().extend(0.0).extend(1.0);
                let columns = DMat4::from_cols(column(x), column(y), glam::DVec4::Z, last);
                bitmap.with("to_uv", matrix(&columns))
            }
        }
    }
}

/// Texture multiplied by a color.
pub(super) fn scaled(texture: Object, factor: [f32; 3]) -> Object {
    match factor == [1.0; 3] {
        true => texture,
        false => object(Kind::Texture, "scale", [("scale", color(factor)), ("texture", nested(texture))]),
    }
}

/// Texel as bytes.
fn texel(image: &TexelImage, at: usize) -> [u8; 4] {
    match &image.texels {
        FileTexels::Bytes(data) => data[at],
        FileTexels::Encoded(data) | FileTexels::Linear(data) => {
            data[at].map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8)
        }
    }
}

/// Texel of an image at a place in the unit square, as bytes.
pub(super) fn at_place(image: &TexelImage, u: f32, v: f32) -> [u8; 4] {
    let index = |place: f32, count: u32| ((place * count as f32) as usize).min(count as usize - 1);
    texel(image, index(v, image.height) * image.width as usize + index(u, image.width))
}

fn extension(content: &[u8]) -> &'static str {
    match content {
        [0x89, b'P', b'N', b'G', ..] => "png",
        [0xff, 0xd8, ..] => "jpg",
        [b'R', b'I', b'F', b'F', ..] => "webp",
        [0xab, b'K', b'T', b'X', ..] => "ktx2",
        _ => "image",
    }
}
