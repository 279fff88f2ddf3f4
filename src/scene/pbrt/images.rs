//! Image files of a scene: those that it names, and those that are computed from them.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::files::Files;
use super::nodes::{ImageFile, Source};
use super::rasters::Raster;
use super::tokens::{Place, brief};
use super::world::Entity;
use crate::Result;
use crate::image::exr;
use crate::image::texels::{self, FileTexels, TexelImage};
use crate::math::srgb::luminance;
use crate::scene::description::object::{self, Value};

/// Most texels of all images that are computed from textures.
const MAX_TEXELS: usize = 1 << 27;

/// Image files of a scene, and the warnings about them.
pub(super) struct Images<'a> {
    pub files: &'a mut Files,
    pub warnings: &'a mut Vec<String>,
    /// Files in memory, for `bitmap`.
    made: HashMap<String, Arc<[u8]>>,
    /// Names of the files of computed images, by address. The images are kept, so that no address comes twice.
    names: HashMap<*const Raster, (String, Rc<Raster>)>,
    /// Mean luminances of the images of lights, by the names of their files.
    luminances: HashMap<String, f64>,
    texel_count: usize,
    /// Number of names of files in memory that were tried.
    name_count: usize,
    /// Messages that were told.
    told: HashSet<String>,
}

impl<'a> Images<'a> {
    pub fn new(files: &'a mut Files, warnings: &'a mut Vec<String>) -> Self {
        let (made, names, luminances, told) = (HashMap::new(), HashMap::new(), HashMap::new(), HashSet::new());
        Self { files, warnings, made, names, luminances, texel_count: 0, name_count: 0, told }
    }

    /// Value of a parameter that names an image file, which may lie in memory.
    pub fn value(&self, name: String) -> Value {
        match self.made.get(&name) {
            Some(bytes) => Value::Image(object::ImageFile { name, bytes: Arc::clone(bytes) }),
            None => Value::Text(name),
        }
    }

    /// Warns of a kind of thing, once, at the place where it is met first.
    pub fn warn(&mut self, place: &Place, message: &str) {
        if self.told.insert(message.to_owned()) {
            self.warnings.push(format!("{place}: {message}"));
        }
    }

    /// Adds a file in memory, of which no other has the name.
    pub fn add_file(&mut self, name: String, content: Vec<u8>) {
        self.made.insert(name, content.into());
    }

    /// The image with other texels, which are bytes, as a file in memory.
    pub fn in_memory(&mut self, image: ImageFile, texels: TexelImage) -> Result<ImageFile> {
        let FileTexels::Bytes(data) = &texels.texels else { return Ok(image) };
        let name = self.new_name("alpha", "png");
        let png = texels::encode_png(Path::new(&name), texels.width, texels.height, data)?;
        self.add_file(name.clone(), png);
        Ok(ImageFile { name, source: Source::Memory(Rc::new(texels)), ..image })
    }

    /// Name for a file in memory, which no file beside the scene has.
    pub fn new_name(&mut self, stem: &str, extension: &str) -> String {
        loop {
            let name = format!("{stem}{}.{extension}", self.name_count);
            self.name_count += 1;
            if !self.files.path(&name).exists() {
                return name;
            }
        }
    }

    /// Texels of an image file.
    pub fn raster_of(&mut self, image: &ImageFile, entity: &Entity) -> Result<Raster> {
        let fault = |error| entity.error(format!("the image `{}`: {error}", brief(&image.name)));
        Ok(match &image.source {
            Source::File(path) => Raster::of(&texels::read(path).map_err(fault)?.in_srgb(), image.encoding),
            Source::Memory(texels) => Raster::of(texels, image.encoding),
        })
    }

    /// Mean luminance of a light's image, whose file is read once. The images of all lights have one encoding.
    pub fn luminance_of(&mut self, image: &ImageFile, entity: &Entity) -> Result<f64> {
        if let Some(&known) = self.luminances.get(&image.name) {
            return Ok(known);
        }
        let mean = luminance(self.raster_of(image, entity)?.mean().as_dvec3().to_array());
        self.luminances.insert(image.name.clone(), mean);
        Ok(mean)
    }

    /// Counts the texels of an image that is to be computed.
    pub fn count(&mut self, width: usize, height: usize, place: &Place) -> Result<()> {
        self.texel_count = self.texel_count.saturating_add(width.saturating_mul(height));
        match self.texel_count > MAX_TEXELS {
            true => {
                Err(place.error("with this texture the computed images have more than 2^27 texels; use smaller images"))
            }
            false => Ok(()),
        }
    }

    /// Name of the file in memory of a computed image.
    pub fn name(&mut self, raster: &Rc<Raster>) -> Result<String> {
        if let Some((name, _)) = self.names.get(&Rc::as_ptr(raster)) {
            return Ok(name.clone());
        }
        let name = self.new_name("texture", "exr");
        let content = exr::encode_rgb(Path::new(&name), &raster.to_image())?;
        self.add_file(name.clone(), content);
        self.names.insert(Rc::as_ptr(raster), (name.clone(), Rc::clone(raster)));
        Ok(name)
    }
}
