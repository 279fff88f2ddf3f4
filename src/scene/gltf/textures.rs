//! Textures to bitmaps. Channels that glTF packs into one image become images of their own, as PNG files in memory.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::DMat4;
use gltf::texture::{Info, MagFilter, Texture, TextureTransform, WrappingMode};

use super::document::Model;
use super::entries::{matrix, object, set, text};
use crate::Result;
use crate::image::texels::{self, FileTexels, TexelImage};
use crate::scene::mitsuba::dictionary::{Dictionary, Value};

/// Texture with the parts that the kinds of reference to it have in common.
pub(super) struct Used<'a> {
    pub texture: Texture<'a>,
    pub transform: Option<TextureTransform<'a>>,
    pub uv_set: u32,
}

impl<'a> From<Info<'a>> for Used<'a> {
    fn from(info: Info<'a>) -> Self {
        let transform = info.texture_transform();
        let uv_set = transform.as_ref().and_then(TextureTransform::tex_coord).unwrap_or(info.tex_coord());
        Self { texture: info.texture(), transform, uv_set }
    }
}

/// Images of a model as files in memory.
pub(super) struct Textures<'m> {
    model: &'m Model<'m>,
    pub files: HashMap<String, Arc<[u8]>>,
    decoded: HashMap<usize, Arc<TexelImage>>,
    pub warnings: Vec<String>,
}

impl<'m> Textures<'m> {
    pub fn new(model: &'m Model<'m>) -> Self {
        Self { model, files: HashMap::new(), decoded: HashMap::new(), warnings: Vec::new() }
    }

    /// Bitmap of a texture's colors.
    pub fn color(&mut self, used: &Used, what: &str) -> Result<Dictionary> {
        let index = self.source(used, what)?;
        let name = format!("{}#image{index}", self.model.name());
        if !self.files.contains_key(&name) {
            self.files.insert(name.clone(), self.model.image(index, what)?);
        }
        Ok(self.bitmap(used, &name, false, what))
    }

    /// Bitmap of numbers that `change` makes of the texels. `role` and `key` name the image: equal ones are made once.
    pub fn derived(
        &mut self,
        used: &Used,
        role: &str,
        key: &str,
        what: &str,
        change: impl Fn([u8; 4]) -> [u8; 4],
    ) -> Result<Dictionary> {
        let index = self.source(used, what)?;
        let name = format!("{}#{role}{index}{key}.png", self.model.name());
        if !self.files.contains_key(&name) {
            let image = self.decoded(index, what)?;
            let changed: Vec<_> = bytes(&image.texels).into_iter().map(change).collect();
            let file = texels::encode_png(Path::new(&name), image.width, image.height, &changed)?;
            self.files.insert(name.clone(), file.into());
        }
        Ok(self.bitmap(used, &name, true, what))
    }

    /// Whether a texel of the texture is not opaque.
    pub fn has_alpha(&mut self, used: &Used, what: &str) -> Result<bool> {
        let index = self.source(used, what)?;
        let image = self.decoded(index, what)?;
        Ok(bytes(&image.texels).iter().any(|texel| texel[3] < 255))
    }

    fn decoded(&mut self, index: usize, what: &str) -> Result<Arc<TexelImage>> {
        if let Some(image) = self.decoded.get(&index) {
            return Ok(Arc::clone(image));
        }
        let name = format!("{}#image{index}", self.model.name());
        let image = texels::decode(Path::new(&name), &self.model.image(index, what)?);
        let image = Arc::new(image.map_err(|error| self.model.error(what, error))?);
        self.decoded.insert(index, Arc::clone(&image));
        Ok(image)
    }

    fn source(&self, used: &Used, what: &str) -> Result<usize> {
        let source = used.texture.source().map(|image| image.index());
        source.ok_or_else(|| {
            let message = "its image is given by an extension alone, such as KHR_texture_basisu; export PNG or JPEG";
            self.model.error(what, format!("texture {}: {message}", used.texture.index()))
        })
    }

    fn bitmap(&mut self, used: &Used, name: &str, raw: bool, what: &str) -> Dictionary {
        let sampler = used.texture.sampler();
        if sampler.wrap_s() != sampler.wrap_t() {
            let message = "the wrap modes of the two axes differ; that of the first is used for both";
            self.warnings.push(format!("{}: {what}: texture {}: {message}", self.model.path.display(), used.texture.index()));
        }
        let wrap = match sampler.wrap_s() {
            WrappingMode::ClampToEdge => "clamp",
            WrappingMode::MirroredRepeat => "mirror",
            WrappingMode::Repeat => "repeat",
        };
        let filter = if sampler.mag_filter() == Some(MagFilter::Nearest) { "nearest" } else { "bilinear" };
        let mut bitmap = object("bitmap", [
            ("filename", text(name)),
            ("wrap_mode", text(wrap)),
            ("filter_type", text(filter)),
            ("raw", Value::Boolean(raw)),
        ]);
        if let Some(transform) = &used.transform {
            set(&mut bitmap, "to_uv", matrix(to_uv(transform)));
        }
        bitmap
    }
}

/// Texture coordinates of the image from those of the mesh (KHR_texture_transform). The rotation is counterclockwise as
/// seen in the image, whose `v` points down.
fn to_uv(transform: &TextureTransform) -> DMat4 {
    let ([u, v], [scale_u, scale_v]) = (transform.offset().map(f64::from), transform.scale().map(f64::from));
    let (sin, cos) = f64::from(transform.rotation()).sin_cos();
    DMat4::from_cols_array_2d(&[
        [cos * scale_u, -sin * scale_u, 0.0, 0.0],
        [sin * scale_v, cos * scale_v, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [u, v, 0.0, 1.0],
    ])
}

/// Texels with 8 bits a channel.
fn bytes(texels: &FileTexels) -> Vec<[u8; 4]> {
    match texels {
        FileTexels::Bytes(data) => data.clone(),
        FileTexels::Encoded(data) | FileTexels::Linear(data) => {
            data.iter().map(|texel| texel.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8)).collect()
        }
    }
}
