//! Textures: trees of images, patterns and constants. Each is reduced to one texture of Mitsuba's, or becomes a texture that kernels
//! compute.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DMat3, DVec2, DVec3};

use super::colors;
use super::image_maps;
use super::images::Images;
use super::mappings;
use super::names::Names;
use super::nodes::{ImageFile, Node, Source, flipped, planar, rgb};
use super::parameters::{Parameter, Parameters};
use super::procedural;
use super::rasters::{Encoding, Raster, Sampling};
use super::tokens::{Place, brief};
use super::world::{Entity, NamedTexture, World};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object};
use crate::scene::description::object::{Object, Value};

/// Deepest nesting of textures.
const MAX_DEPTH: usize = 64;

/// Textures of a scene, each reduced when it is first used.
pub(super) struct Textures<'a> {
    pub world: &'a World,
    pub images: Images<'a>,
    /// Reduced textures by their names, and whether they give numbers.
    known: HashMap<(bool, &'a str), Node>,
    pub names: &'a Names,
    /// Textures that kernels compute, with their labels.
    pub objects: Vec<(String, Object)>,
}

impl<'a> Textures<'a> {
    pub fn new(world: &'a World, images: Images<'a>, names: &'a Names) -> Self {
        Self { world, images, known: HashMap::new(), names, objects: Vec::new() }
    }

    /// Objects of the textures that kernels compute.
    pub fn take_objects(&mut self) -> Vec<(String, Object)> {
        std::mem::take(&mut self.objects)
    }

    /// Color of a material: a constant or a texture.
    pub fn color(&mut self, parameters: &Parameters, entity: &Entity, name: &str, default: f64) -> Result<Node> {
        match parameters.get(name) {
            None => Ok(Node::Constant([default; 3])),
            Some(parameter) => self.color_of(parameter, entity, usize::MAX, 0),
        }
    }

    /// Number: a constant or a texture.
    pub fn number(&mut self, parameters: &Parameters, name: &str, default: f64) -> Result<Node> {
        self.number_at(parameters, name, default, 0)
    }

    /// Number that `depth` textures contain.
    fn number_at(&mut self, parameters: &Parameters, name: &str, default: f64, depth: usize) -> Result<Node> {
        match parameters.get(name) {
            None => Ok(Node::Constant([default; 3])),
            Some(parameter) => self.number_of(parameter, usize::MAX, depth),
        }
    }

    /// Value of a parameter that gives a color. Textures whose number is `below` or higher are not yet defined. `depth`
    /// textures contain the parameter.
    fn color_of(&mut self, parameter: &Parameter, entity: &Entity, below: usize, depth: usize) -> Result<Node> {
        if parameter.kind != "texture" {
            return colors::of_material(parameter, entity.color_space, self.images.files).map(Node::Constant);
        }
        self.named(false, parameter, below, depth)
    }

    /// Value of a parameter that gives a number, with the bounds of [`Self::color_of`].
    pub fn number_of(&mut self, parameter: &Parameter, below: usize, depth: usize) -> Result<Node> {
        if parameter.kind != "texture" {
            return parameter.number().map(|number| Node::Constant([number; 3]));
        }
        self.named(true, parameter, below, depth)
    }

    fn named(&mut self, is_number: bool, parameter: &Parameter, below: usize, depth: usize) -> Result<Node> {
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
        if depth > MAX_DEPTH {
            let message = format!("textures are nested more than {MAX_DEPTH} deep: does one contain itself?");
            return Err(texture.entity.error(message));
        }
        let node = self.read(texture, is_number, depth + 1)?;
        self.images.warnings.extend(texture.entity.parameters.unread());
        self.known.insert((is_number, name), node.clone());
        Ok(node)
    }

    /// Reduces a texture. `depth` textures contain its parameters, with itself.
    fn read(&mut self, texture: &NamedTexture, is_number: bool, depth: usize) -> Result<Node> {
        let NamedTexture { entity, number: below } = texture;
        let parameters = &entity.parameters;
        let mut part = |name: &str, default: f64| match parameters.get(name) {
            None => Ok(Node::Constant([default; 3])),
            Some(parameter) if is_number => self.number_of(parameter, *below, depth),
            Some(parameter) => self.color_of(parameter, entity, *below, depth),
        };
        match entity.kind.as_str() {
            "constant" => part("value", 1.0),
            "scale" => {
                let inner = part("tex", 1.0)?;
                match self.number_at(parameters, "scale", 1.0, depth)? {
                    Node::Constant([factor, ..]) => self.scaled(inner, factor, entity),
                    factor => self.combined(
                        &[inner, factor],
                        entity,
                        |values| values[0] * values[1],
                        |[a, b]| mappings::texture("multiply", [("a", a), ("b", b)]),
                    ),
                }
            }
            "mix" => {
                let (first, second) = (part("tex1", 0.0)?, part("tex2", 1.0)?);
                let amount = self.number_at(parameters, "amount", 0.5, depth)?;
                self.mixed([first, second, amount], entity)
            }
            "checkerboard"
                if parameters.integer("dimension", 2..=3)? != Some(3) && mappings::of_position(entity)?.is_none() =>
            {
                let (first, second) = (part("tex1", 1.0)?, part("tex2", 0.0)?);
                if let (Node::Constant(first), Node::Constant(second)) = (&first, &second) {
                    // Mitsuba's squares are half as large.
                    let to_uv = DMat3::from_scale(DVec2::splat(0.5)) * mappings::of_uv(entity)?;
                    return Ok(Node::Checkerboard { colors: [*first, *second], to_uv });
                }
                self.chosen(first, second, entity)
            }
            "checkerboard" => {
                let (first, second) = (part("tex1", 1.0)?, part("tex2", 0.0)?);
                self.chosen(first, second, entity)
            }
            "directionmix" => {
                let (first, second) = (part("tex1", 0.0)?, part("tex2", 1.0)?);
                self.chosen(second, first, entity)
            }
            "dots" => {
                // As in pbrt, `inside` and `outside` are exchanged.
                let (inside, outside) = (part("inside", 1.0)?, part("outside", 0.0)?);
                self.chosen(inside, outside, entity)
            }
            "bilerp" => {
                let corners = [("v00", 0.0), ("v10", 0.0), ("v01", 1.0), ("v11", 1.0)];
                let nodes = corners.map(|(name, default)| part(name, default));
                let [v00, v10, v01, v11] = nodes;
                let nodes = [v00?, v10?, v01?, v11?];
                let mean = nodes.iter().map(Node::rough_mean).sum::<DVec3>() / 4.0;
                let values = [
                    self.operand(&nodes[0])?,
                    self.operand(&nodes[1])?,
                    self.operand(&nodes[2])?,
                    self.operand(&nodes[3])?,
                ];
                let value = procedural::bilerp(entity, values)?;
                Ok(self.computed(value, mean, entity))
            }
            "imagemap" => {
                let node = image_maps::read(&mut self.images, entity, is_number)?;
                let node = match mappings::of_position(entity)? {
                    None => node,
                    Some(coordinates) => self.placed(node, coordinates, entity)?,
                };
                match parameters.text("wrap")? {
                    Some(image_maps::BLACK) => self.bordered(&node, entity),
                    _ => Ok(node),
                }
            }
            "marble" if !is_number => {
                let (value, mean) = procedural::marble(entity)?;
                Ok(self.computed(value, DVec3::splat(mean), entity))
            }
            other => match procedural::number(entity)? {
                Some((value, mean)) if is_number => Ok(self.computed(value, DVec3::splat(mean), entity)),
                Some(_) => Err(entity.error(format!("the texture `{other}` gives a `float`, not a `spectrum`"))),
                None => {
                    Err(entity.error(format!("the texture `{}` is not supported; use an `imagemap`", brief(other))))
                }
            },
        }
    }

    /// Mean of a texture that gives a number.
    pub fn mean(&mut self, node: &Node, entity: &Entity) -> Result<f64> {
        Ok(match node {
            Node::Constant([number, ..]) => *number,
            Node::Checkerboard { colors: [[first, ..], [second, ..]], .. } => 0.5 * (first + second),
            Node::Computed { mean: [mean, ..], .. } => *mean,
            node => self.raster(node, entity)?.map_or(0.0, |(raster, _)| f64::from(raster.mean().x)),
        })
    }

    /// Texels of an image; `None` for other textures.
    pub fn raster(&mut self, node: &Node, entity: &Entity) -> Result<Option<(Rc<Raster>, Sampling)>> {
        Ok(match node {
            Node::Constant(_) | Node::Checkerboard { .. } | Node::Computed { .. } => None,
            Node::Raster { raster, sampling } => Some((Rc::clone(raster), *sampling)),
            Node::Image { image, factor } => {
                let raster = self.images.raster_of(image, entity)?.map(|texel| texel * *factor as f32);
                Some((Rc::new(raster), image.sampling))
            }
        })
    }

    /// Value of a parameter that is a color.
    pub fn color_value(&mut self, node: &Node) -> Result<Value> {
        Ok(match node {
            Node::Constant(color) => rgb(*color),
            Node::Computed { id, .. } => Value::Reference(id.clone()),
            other => nested(self.texture(other, false)?),
        })
    }

    /// Value of a parameter that is a number.
    pub fn number_value(&mut self, node: &Node) -> Result<Value> {
        Ok(match node {
            Node::Constant([number, ..]) => Value::Float(*number),
            Node::Computed { id, .. } => Value::Reference(id.clone()),
            other => nested(self.texture(other, true)?),
        })
    }

    /// Texture of Mitsuba's.
    pub fn texture(&mut self, node: &Node, is_number: bool) -> Result<Object> {
        let (name, sampling, is_raw, factor) = match node {
            Node::Constant(color) => {
                return Ok(object(Kind::Texture, "rawconstant", [("value", Value::Vector(*color))]));
            }
            // It is referred to, not nested.
            Node::Computed { mean, .. } => {
                return Ok(object(Kind::Texture, "rawconstant", [("value", Value::Vector(*mean))]));
            }
            Node::Checkerboard { colors: [even, odd], to_uv } => {
                // Mitsuba exchanges the colors where they give a number.
                let (first, second) = if is_number { (odd, even) } else { (even, odd) };
                let entries = [("color0", rgb(*first)), ("color1", rgb(*second)), ("to_uv", planar(to_uv))];
                return Ok(object(Kind::Texture, "checkerboard", entries));
            }
            Node::Image { image, factor } => {
                (image.name.clone(), image.sampling, image.encoding == Encoding::Linear, *factor)
            }
            Node::Raster { raster, sampling } => (self.images.name(raster)?, *sampling, true, 1.0),
        };
        let entries = [
            ("filename", self.images.value(name)),
            ("raw", Value::Boolean(is_raw)),
            ("wrap_mode", Value::Text(sampling.wrap.into())),
            ("filter_type", Value::Text(sampling.filter.into())),
        ];
        let mut bitmap = object(Kind::Texture, "bitmap", entries);
        if sampling.to_uv != DMat3::IDENTITY {
            bitmap = bitmap.with("to_uv", planar(&sampling.to_uv));
        }
        Ok(match factor == 1.0 {
            true => bitmap,
            false => object(Kind::Texture, "scale", [("scale", Value::Float(factor)), ("texture", nested(bitmap))]),
        })
    }

    /// Image file of a light or of normals, as `bitmap`. Both lie on the surface as an `imagemap` does.
    pub fn bitmap(&mut self, name: &str, encoding: Encoding, place: &Place) -> Result<Node> {
        let path = self.images.files.existing(name, "image file", place)?;
        let sampling = Sampling { to_uv: flipped(DMat3::IDENTITY), wrap: "repeat", filter: "bilinear" };
        Ok(Node::Image {
            image: ImageFile { name: name.to_owned(), source: Source::File(path), encoding, sampling },
            factor: 1.0,
        })
    }

    /// Heights or normals that a texture gives; `None` where they are the same everywhere, or a checkerboard's.
    pub fn heights(&mut self, node: &Node) -> Result<Option<Value>> {
        match node {
            Node::Image { .. } | Node::Raster { .. } => self.texture(node, true).map(|texture| Some(nested(texture))),
            Node::Computed { id, .. } => Ok(Some(Value::Reference(id.clone()))),
            Node::Constant(_) | Node::Checkerboard { .. } => Ok(None),
        }
    }
}
