//! Textures: trees of images, patterns and constants, each reduced to one texture of Mitsuba's.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec2, DVec3, Vec3};

use super::colors;
use super::files::{self, Files};
use super::parameters::{Parameter, Parameters};
use super::rasters::{self, Encoding, Raster, Sampling};
use super::tokens::{Place, brief};
use super::world::{Entity, NamedTexture, World};
use crate::Result;
use crate::image::exr;
use crate::image::texels::{self, FileTexels, TexelImage};
use crate::scene::values::{matrix, object, with};
use crate::scene::{Array, Dictionary, Value};

/// Most texels of all images that are computed from textures.
const MAX_TEXELS: usize = 1 << 27;

/// Texture reduced as far as it can be. Numbers are gray colors.
#[derive(Debug, Clone)]
pub(super) enum Node {
    Constant([f64; 3]),
    /// Two colors in turn: the first where the whole parts of both coordinates have an even sum.
    Checkerboard {
        colors: [[f64; 3]; 2],
        to_uv: DMat3,
    },
    /// Image of a file, times a factor.
    Image {
        image: ImageFile,
        factor: f64,
    },
    /// Image that was computed.
    Raster {
        raster: Rc<Raster>,
        sampling: Sampling,
    },
}

/// Image file as a texture uses it.
#[derive(Debug, Clone)]
pub(super) struct ImageFile {
    /// Name that a `bitmap` has.
    name: String,
    source: Source,
    encoding: Encoding,
    sampling: Sampling,
}

#[derive(Debug, Clone)]
enum Source {
    File(PathBuf),
    Memory(Rc<TexelImage>),
}

/// Textures of a scene, each reduced when it is first used.
pub(super) struct Textures<'a> {
    pub world: &'a World,
    pub files: &'a mut Files,
    pub warnings: &'a mut Vec<String>,
    /// Reduced textures by their names, and whether they give numbers.
    known: HashMap<(bool, &'a str), Node>,
    /// Files in memory, for `bitmap`.
    made: HashMap<String, Arc<[u8]>>,
    /// Names of the files of computed images, by address. The images are kept, so that no address comes twice.
    names: HashMap<*const Raster, (String, Rc<Raster>)>,
    texel_count: usize,
    /// Messages that were told.
    told: HashSet<String>,
}

impl<'a> Textures<'a> {
    pub fn new(world: &'a World, files: &'a mut Files, warnings: &'a mut Vec<String>) -> Self {
        let (known, made, names) = (HashMap::new(), HashMap::new(), HashMap::new());
        Self { world, files, warnings, known, made, names, texel_count: 0, told: HashSet::new() }
    }

    /// Warns of a kind of thing, once, at the place where it is met first.
    pub fn warn(&mut self, place: &Place, message: &str) {
        if self.told.insert(message.to_owned()) {
            self.warnings.push(format!("{place}: {message}"));
        }
    }

    /// Files in memory.
    pub fn finish(self) -> HashMap<String, Arc<[u8]>> {
        self.made
    }

    /// Adds a file in memory, of which no other has the name.
    pub fn add_file(&mut self, name: String, content: Vec<u8>) {
        self.made.insert(name, content.into());
    }

    /// Color of a material: a constant or a texture.
    pub fn color(&mut self, parameters: &Parameters, entity: &Entity, name: &str, default: f64) -> Result<Node> {
        match parameters.get(name) {
            None => Ok(Node::Constant([default; 3])),
            Some(parameter) => self.color_of(parameter, entity, usize::MAX),
        }
    }

    /// Number: a constant or a texture.
    pub fn number(&mut self, parameters: &Parameters, name: &str, default: f64) -> Result<Node> {
        match parameters.get(name) {
            None => Ok(Node::Constant([default; 3])),
            Some(parameter) => self.number_of(parameter, usize::MAX),
        }
    }

    /// Value of a parameter that gives a color. Textures whose number is `below` or higher are not yet defined.
    fn color_of(&mut self, parameter: &Parameter, entity: &Entity, below: usize) -> Result<Node> {
        if parameter.kind != "texture" {
            return colors::of_material(parameter, entity.color_space, self.files).map(Node::Constant);
        }
        self.named(false, parameter, below)
    }

    pub fn number_of(&mut self, parameter: &Parameter, below: usize) -> Result<Node> {
        if parameter.kind != "texture" {
            return parameter.number().map(|number| Node::Constant([number; 3]));
        }
        self.named(true, parameter, below)
    }

    fn named(&mut self, is_number: bool, parameter: &Parameter, below: usize) -> Result<Node> {
        let name = parameter.text()?;
        let world = self.world;
        let list = if is_number { &world.numbers } else { &world.colors };
        let Some((name, texture)) = list.get_key_value(name).filter(|(_, texture)| texture.number < below) else {
            let value = if is_number { "float" } else { "spectrum" };
            let message = format!(
                "names the texture `{}`, but no texture of that name that gives a `{value}` stands before",
                brief(name)
            );
            return Err(parameter.error(message));
        };
        if let Some(node) = self.known.get(&(is_number, name.as_str())) {
            return Ok(node.clone());
        }
        let node = self.read(texture, is_number)?;
        self.warnings.extend(texture.entity.parameters.unread());
        self.known.insert((is_number, name), node.clone());
        Ok(node)
    }

    fn read(&mut self, texture: &NamedTexture, is_number: bool) -> Result<Node> {
        let NamedTexture { entity, number: below } = texture;
        let parameters = &entity.parameters;
        let mut part = |name: &str, default: f64| match parameters.get(name) {
            None => Ok(Node::Constant([default; 3])),
            Some(parameter) if is_number => self.number_of(parameter, *below),
            Some(parameter) => self.color_of(parameter, entity, *below),
        };
        match entity.kind.as_str() {
            "constant" => part("value", 1.0),
            "scale" => {
                let inner = part("tex", 1.0)?;
                match self.number(parameters, "scale", 1.0)? {
                    Node::Constant([factor, ..]) => self.scaled(inner, factor, entity),
                    factor => self.combined(&[inner, factor], entity, |values| values[0] * values[1]),
                }
            }
            "mix" => {
                let (first, second) = (part("tex1", 0.0)?, part("tex2", 1.0)?);
                let amount = self.number(parameters, "amount", 0.5)?;
                self.combined(&[first, second, amount], entity, |values| {
                    values[0] + (values[1] - values[0]) * values[2]
                })
            }
            "checkerboard" => {
                let (first, second) = (part("tex1", 1.0)?, part("tex2", 0.0)?);
                if parameters.integer("dimension", 2..=3)? == Some(3) {
                    return Err(entity.error("a `checkerboard` of three dimensions is not supported; use two"));
                }
                let (Node::Constant(first), Node::Constant(second)) = (first, second) else {
                    return Err(entity.error("a `checkerboard` of textures is not supported; use constants"));
                };
                // Mitsuba's squares are half as large.
                let to_uv = DMat3::from_scale(DVec2::splat(0.5)) * mapping(entity)?;
                Ok(Node::Checkerboard { colors: [first, second], to_uv })
            }
            "imagemap" => self.image(entity, is_number),
            other => {
                let message = format!("the texture `{}` is not supported; use an `imagemap`", brief(other));
                Err(entity.error(message))
            }
        }
    }

    fn image(&mut self, entity: &Entity, is_number: bool) -> Result<Node> {
        let parameters = &entity.parameters;
        parameters.ignore(&["maxanisotropy"]);
        let name = parameters.text("filename")?;
        let name = name.ok_or_else(|| entity.error("an `imagemap` needs its parameter \"string filename\""))?;
        let filter = match parameters.text("filter")?.unwrap_or("bilinear") {
            "point" => "nearest",
            "bilinear" => "bilinear",
            other @ ("trilinear" | "EWA" | "ewa") => {
                self.warn(&parameters.place, &format!("the filter `{other}` is not supported; `bilinear` is used"));
                "bilinear"
            }
            other => {
                return Err(
                    entity.error(format!("the filter `{}` is not known; use `bilinear` or `point`", brief(other)))
                );
            }
        };
        let wrap = match parameters.text("wrap")?.unwrap_or("repeat") {
            "repeat" => "repeat",
            "clamp" => "clamp",
            other => {
                return Err(
                    entity.error(format!("the wrap mode `{}` is not supported; use `repeat` or `clamp`", brief(other)))
                );
            }
        };
        let (factor, is_inverted) = (parameters.number("scale", 1.0)?, parameters.boolean("invert", false)?);
        let encoding = self.encoding(parameters, name)?;
        let path = self.files.existing(name, "image file", &parameters.place)?;
        let sampling = Sampling { to_uv: flipped(mapping(entity)?), wrap, filter };
        let mut image = ImageFile { name: name.to_owned(), source: Source::File(path.clone()), encoding, sampling };
        let mut averages = false;
        if is_number {
            let texels =
                texels::read(&path).map_err(|error| entity.error(format!("the image `{}`: {error}", brief(name))))?;
            match has_alpha(&path)?.then(|| rasters::alpha(&texels)).flatten() {
                Some(alpha) => image = self.in_memory(image, alpha)?,
                None => averages = !rasters::is_gray(&texels),
            }
        }
        if !averages && !is_inverted && !matches!(encoding, Encoding::Gamma(_)) && factor >= 0.0 {
            return Ok(Node::Image { image, factor });
        }
        let change = |texel: Vec3| {
            let texel = if averages { Vec3::splat(texel.element_sum() / 3.0) } else { texel };
            let scaled = texel * factor as f32;
            if is_inverted { (1.0 - scaled).max(Vec3::ZERO) } else { scaled }
        };
        let raster = self.raster_of(&image, entity)?.map(change);
        self.count(&raster, &parameters.place)?;
        Ok(Node::Raster { raster: Rc::new(raster), sampling })
    }

    /// Reads the encoding of an image. As in pbrt, it matters to PNG files alone; other files of bytes follow the sRGB curve.
    fn encoding(&mut self, parameters: &Parameters, name: &str) -> Result<Encoding> {
        let given = parameters.text("encoding")?;
        if !Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            return Ok(Encoding::Srgb);
        }
        let given = given.unwrap_or("sRGB");
        let gamma = || {
            given.strip_prefix("gamma ")?.trim().parse().ok().filter(|gamma: &f64| gamma.is_finite() && *gamma > 0.0)
        };
        match given {
            "sRGB" => Ok(Encoding::Srgb),
            "linear" => Ok(Encoding::Linear),
            _ => gamma().map(Encoding::Gamma).ok_or_else(|| {
                let message =
                    format!("the encoding `{}` is not known; use `sRGB`, `linear` or `gamma 2.2`", brief(given));
                parameters.error(message)
            }),
        }
    }

    /// The image with other texels, as a file in memory where they are bytes.
    fn in_memory(&mut self, image: ImageFile, texels: TexelImage) -> Result<ImageFile> {
        let mut name = image.name.clone();
        if let FileTexels::Bytes(data) = &texels.texels {
            name = format!("alpha{}.png", self.made.len());
            let png = texels::encode_png(Path::new(&name), texels.width, texels.height, data)?;
            self.add_file(name.clone(), png);
        }
        Ok(ImageFile { name, source: Source::Memory(Rc::new(texels)), ..image })
    }

    fn raster_of(&mut self, image: &ImageFile, entity: &Entity) -> Result<Raster> {
        let fault = |error| entity.error(format!("the image `{}`: {error}", brief(&image.name)));
        Ok(match &image.source {
            Source::File(path) => Raster::of(&texels::read(path).map_err(fault)?, image.encoding),
            Source::Memory(texels) => Raster::of(texels, image.encoding),
        })
    }

    /// The texture times a factor.
    pub fn scaled(&mut self, node: Node, by: f64, entity: &Entity) -> Result<Node> {
        match node {
            Node::Image { image, factor } if by >= 0.0 => Ok(Node::Image { image, factor: factor * by }),
            node => self.combined(&[node], entity, |values| values[0] * by),
        }
    }

    /// Mean of a texture that gives a number.
    pub fn mean(&mut self, node: &Node, entity: &Entity) -> Result<f64> {
        Ok(match node {
            Node::Constant([number, ..]) => *number,
            Node::Checkerboard { colors: [[first, ..], [second, ..]], .. } => 0.5 * (first + second),
            node => self.raster(node, entity)?.map_or(0.0, |(raster, _)| f64::from(raster.mean().x)),
        })
    }

    /// The texture with a function applied to its values.
    pub fn mapped(&mut self, node: Node, entity: &Entity, change: impl Fn(Vec3) -> Vec3) -> Result<Node> {
        self.combined(&[node], entity, |values| change(values[0].as_vec3()).as_dvec3())
    }

    /// Function of several textures, which must lie alike on the surface.
    fn combined(&mut self, nodes: &[Node], entity: &Entity, function: impl Fn(&[DVec3]) -> DVec3) -> Result<Node> {
        let constant = |node: &Node| match node {
            Node::Constant(color) => Some(DVec3::from(*color)),
            _ => None,
        };
        let varying: Vec<usize> = (0..nodes.len()).filter(|&index| constant(&nodes[index]).is_none()).collect();
        let with_varying = |values: &[DVec3]| {
            let mut values = values.iter();
            let all: Vec<DVec3> = nodes
                .iter()
                .map(|node| constant(node).or_else(|| values.next().copied()).unwrap_or_default())
                .collect();
            function(&all)
        };
        let clash = || {
            entity.error("textures that lie differently on the surface cannot be combined; combine them in one image")
        };
        match (&varying[..], varying.first().map(|&first| &nodes[first])) {
            ([], _) => Ok(Node::Constant(with_varying(&[]).to_array())),
            ([_], Some(Node::Checkerboard { colors, to_uv })) => {
                let colors = colors.map(|color| with_varying(&[color.into()]).to_array());
                Ok(Node::Checkerboard { colors, to_uv: *to_uv })
            }
            _ => {
                let mut rasters = Vec::new();
                let mut common = None;
                for &index in &varying {
                    let (raster, sampling) = self.raster(&nodes[index], entity)?.ok_or_else(clash)?;
                    if *common.get_or_insert(sampling) != sampling {
                        return Err(clash());
                    }
                    rasters.push(raster);
                }
                let sampling = common.ok_or_else(clash)?;
                let width = rasters.iter().map(|raster| raster.width).max().unwrap_or(1);
                let height = rasters.iter().map(|raster| raster.height).max().unwrap_or(1);
                let rasters: Vec<_> = rasters.iter().map(|raster| raster.resized(width, height, &sampling)).collect();
                let texel = |at: usize| {
                    let values: Vec<DVec3> = rasters.iter().map(|raster| raster.texels[at].as_dvec3()).collect();
                    with_varying(&values).as_vec3()
                };
                let raster = Raster { width, height, texels: (0..width * height).map(texel).collect() };
                self.count(&raster, &entity.parameters.place)?;
                Ok(Node::Raster { raster: Rc::new(raster), sampling })
            }
        }
    }

    /// Texels of an image; `None` for other textures.
    pub fn raster(&mut self, node: &Node, entity: &Entity) -> Result<Option<(Rc<Raster>, Sampling)>> {
        Ok(match node {
            Node::Constant(_) | Node::Checkerboard { .. } => None,
            Node::Raster { raster, sampling } => Some((Rc::clone(raster), *sampling)),
            Node::Image { image, factor } => {
                let raster = self.raster_of(image, entity)?.map(|texel| texel * *factor as f32);
                Some((Rc::new(raster), image.sampling))
            }
        })
    }

    fn count(&mut self, raster: &Raster, place: &Place) -> Result<()> {
        self.texel_count += raster.texels.len();
        match self.texel_count > MAX_TEXELS {
            true => {
                Err(place.error("with this texture the computed images have more than 2^27 texels; use smaller images"))
            }
            false => Ok(()),
        }
    }

    /// Value of a parameter that is a color.
    pub fn color_value(&mut self, node: &Node) -> Result<Value> {
        Ok(match node {
            Node::Constant(color) => rgb(*color),
            other => Value::Object(self.texture(other, false)?),
        })
    }

    /// Value of a parameter that is a number.
    pub fn number_value(&mut self, node: &Node) -> Result<Value> {
        Ok(match node {
            Node::Constant([number, ..]) => Value::Number(*number),
            other => Value::Object(self.texture(other, true)?),
        })
    }

    /// Texture of Mitsuba's.
    fn texture(&mut self, node: &Node, is_number: bool) -> Result<Dictionary> {
        let (name, sampling, is_raw, factor) = match node {
            Node::Constant(color) => {
                let value = Value::Array(Array { shape: vec![3], values: color.to_vec() });
                return Ok(object("rawconstant", [("value", value)]));
            }
            Node::Checkerboard { colors: [even, odd], to_uv } => {
                // Mitsuba exchanges the colors where they give a number.
                let (first, second) = if is_number { (odd, even) } else { (even, odd) };
                let entries = [("color0", rgb(*first)), ("color1", rgb(*second)), ("to_uv", planar(to_uv))];
                return Ok(object("checkerboard", entries));
            }
            Node::Image { image, factor } => {
                (image.name.clone(), image.sampling, image.encoding == Encoding::Linear, *factor)
            }
            Node::Raster { raster, sampling } => (self.name(raster)?, *sampling, true, 1.0),
        };
        let entries = [
            ("filename", Value::Text(name)),
            ("raw", Value::Boolean(is_raw)),
            ("wrap_mode", Value::Text(sampling.wrap.into())),
            ("filter_type", Value::Text(sampling.filter.into())),
        ];
        let mut bitmap = object("bitmap", entries);
        if sampling.to_uv != DMat3::IDENTITY {
            bitmap = with(bitmap, "to_uv", planar(&sampling.to_uv));
        }
        Ok(match factor == 1.0 {
            true => bitmap,
            false => object("scale", [("scale", Value::Number(factor)), ("texture", Value::Object(bitmap))]),
        })
    }

    /// Name of the file in memory of a computed image.
    fn name(&mut self, raster: &Rc<Raster>) -> Result<String> {
        if let Some((name, _)) = self.names.get(&Rc::as_ptr(raster)) {
            return Ok(name.clone());
        }
        let name = format!("texture{}.exr", self.names.len());
        let content = exr::encode_rgb(Path::new(&name), &raster.to_image())?;
        self.add_file(name.clone(), content);
        self.names.insert(Rc::as_ptr(raster), (name.clone(), Rc::clone(raster)));
        Ok(name)
    }

    /// Image file of a light or of normals, as `bitmap`. Both lie on the surface as an `imagemap` does.
    pub fn bitmap(&mut self, name: &str, encoding: Encoding, place: &Place) -> Result<Node> {
        let path = self.files.existing(name, "image file", place)?;
        let sampling = Sampling { to_uv: flipped(DMat3::IDENTITY), wrap: "repeat", filter: "bilinear" };
        Ok(Node::Image {
            image: ImageFile { name: name.to_owned(), source: Source::File(path), encoding, sampling },
            factor: 1.0,
        })
    }

    /// The texture of Mitsuba's of an image.
    pub fn image_texture(&mut self, node: &Node) -> Result<Option<Dictionary>> {
        match node {
            Node::Image { .. } | Node::Raster { .. } => self.texture(node, true).map(Some),
            Node::Constant(_) | Node::Checkerboard { .. } => Ok(None),
        }
    }
}

/// Color in linear sRGB.
pub(super) fn rgb(color: [f64; 3]) -> Value {
    Value::Object(object("rgb", [("value", Value::Array(Array { shape: vec![3], values: color.to_vec() }))]))
}

/// Reads the mapping from the surface's coordinates to the texture's.
fn mapping(entity: &Entity) -> Result<DMat3> {
    let parameters = &entity.parameters;
    match parameters.text("mapping")? {
        None | Some("uv") => {}
        Some(other) => {
            return Err(entity.error(format!("the mapping `{}` is not supported; use `uv`", brief(other))));
        }
    }
    let scale = DVec2::new(parameters.number("uscale", 1.0)?, parameters.number("vscale", 1.0)?);
    let offset = DVec2::new(parameters.number("udelta", 0.0)?, parameters.number("vdelta", 0.0)?);
    Ok(DMat3::from_translation(offset) * DMat3::from_scale(scale))
}

/// The mapping with `v` from the image's top, which in pbrt runs from its bottom.
fn flipped(mapping: DMat3) -> DMat3 {
    DMat3::from_translation(DVec2::Y) * DMat3::from_scale(DVec2::new(1.0, -1.0)) * mapping
}

/// Transform of texture coordinates.
fn planar(to_uv: &DMat3) -> Value {
    let column = |column: DVec3, last: f64| column.truncate().extend(0.0).extend(last);
    let columns = [column(to_uv.x_axis, 0.0), column(to_uv.y_axis, 0.0), glam::DVec4::Z, column(to_uv.z_axis, 1.0)];
    matrix(&DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]))
}

/// Whether a file is a PNG image of red, green, blue and alpha. pbrt reads alpha from no other file with bytes.
fn has_alpha(path: &Path) -> Result<bool> {
    const COLOR_TYPE: usize = 25;
    const RGBA: u8 = 6;
    let (beginning, _) = files::beginning(path, COLOR_TYPE as u64 + 1)?;
    Ok(beginning.starts_with(&[0x89, b'P', b'N', b'G']) && beginning.get(COLOR_TYPE) == Some(&RGBA))
}
