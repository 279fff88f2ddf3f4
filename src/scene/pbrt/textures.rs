//! Textures: trees of images, patterns and constants, each reduced to one texture of Mitsuba's.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DMat3, DVec2, DVec3, Vec3};

use super::colors;
use super::image_maps;
use super::images::Images;
use super::nodes::{ImageFile, Node, Source, flipped, mapping, planar, rgb};
use super::parameters::{Parameter, Parameters};
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
}

impl<'a> Textures<'a> {
    pub fn new(world: &'a World, images: Images<'a>) -> Self {
        Self { world, images, known: HashMap::new() }
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
                    factor => self.combined(&[inner, factor], entity, |values| values[0] * values[1]),
                }
            }
            "mix" => {
                let (first, second) = (part("tex1", 0.0)?, part("tex2", 1.0)?);
                let amount = self.number_at(parameters, "amount", 0.5, depth)?;
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
            "imagemap" => image_maps::read(&mut self.images, entity, is_number),
            other => {
                let message = format!("the texture `{}` is not supported; use an `imagemap`", brief(other));
                Err(entity.error(message))
            }
        }
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
    pub fn combined(&mut self, nodes: &[Node], entity: &Entity, function: impl Fn(&[DVec3]) -> DVec3) -> Result<Node> {
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
                self.images.count(width, height, &entity.parameters.place)?;
                let rasters: Vec<_> = rasters.iter().map(|raster| raster.resized(width, height, &sampling)).collect();
                let texel = |at: usize| {
                    let values: Vec<DVec3> = rasters.iter().map(|raster| raster.texels[at].as_dvec3()).collect();
                    with_varying(&values).as_vec3()
                };
                let raster = Raster { width, height, texels: (0..width * height).map(texel).collect() };
                Ok(Node::Raster { raster: Rc::new(raster), sampling })
            }
        }
    }

    /// Texels of an image; `None` for other textures.
    fn raster(&mut self, node: &Node, entity: &Entity) -> Result<Option<(Rc<Raster>, Sampling)>> {
        Ok(match node {
            Node::Constant(_) | Node::Checkerboard { .. } => None,
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
            other => nested(self.texture(other, false)?),
        })
    }

    /// Value of a parameter that is a number.
    pub fn number_value(&mut self, node: &Node) -> Result<Value> {
        Ok(match node {
            Node::Constant([number, ..]) => Value::Float(*number),
            other => nested(self.texture(other, true)?),
        })
    }

    /// Texture of Mitsuba's.
    fn texture(&mut self, node: &Node, is_number: bool) -> Result<Object> {
        let (name, sampling, is_raw, factor) = match node {
            Node::Constant(color) => {
                return Ok(object(Kind::Texture, "rawconstant", [("value", Value::Vector(*color))]));
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

    /// The texture of Mitsuba's of an image.
    pub fn image_texture(&mut self, node: &Node) -> Result<Option<Object>> {
        match node {
            Node::Image { .. } | Node::Raster { .. } => self.texture(node, true).map(Some),
            Node::Constant(_) | Node::Checkerboard { .. } => Ok(None),
        }
    }
}
