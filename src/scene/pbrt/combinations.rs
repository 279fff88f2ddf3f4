//! Textures made of others: images where that is possible, and else textures that kernels compute.

use std::rc::Rc;

use glam::{DMat3, DVec2, DVec3};

use super::mappings::{self, texture};
use super::nodes::{Node, rgb};
use super::procedural;
use super::rasters::{Raster, Sampling};
use super::textures::Textures;
use super::world::Entity;
use crate::Result;
use crate::scene::description::make::nested;
use crate::scene::description::object::Value;

impl Textures<'_> {
    /// The texture times a factor.
    pub fn scaled(&mut self, node: Node, by: f64, entity: &Entity) -> Result<Node> {
        match node {
            Node::Image { image, factor } if by >= 0.0 => Ok(Node::Image { image, factor: factor * by }),
            node => self.combined(
                &[node],
                entity,
                |values| values[0] * by,
                |[value]| texture("multiply", [("a", value), ("b", Value::Float(by))]),
            ),
        }
    }

    /// The square root of a texture; 0 where it is negative.
    pub fn square_root(&mut self, node: Node, entity: &Entity) -> Result<Node> {
        self.combined(
            &[node],
            entity,
            |values| values[0].as_vec3().max(glam::Vec3::ZERO).map(f32::sqrt).as_dvec3(),
            |[value]| texture("square_root", [("value", value)]),
        )
    }

    /// Mix of two textures by a third: (1 - amount) first + amount second.
    pub fn mixed(&mut self, nodes: [Node; 3], entity: &Entity) -> Result<Node> {
        self.combined(
            &nodes,
            entity,
            |values| values[0] + (values[1] - values[0]) * values[2],
            |[a, b, weight]| texture("mix", [("a", a), ("b", b), ("weight", weight)]),
        )
    }

    /// Texture that chooses between two by the pattern of the entity.
    pub fn chosen(&mut self, first: Node, second: Node, entity: &Entity) -> Result<Node> {
        let Some((weight, share)) = procedural::weight(entity)? else { return Ok(first) };
        let mean = first.rough_mean().lerp(second.rough_mean(), share);
        let entries = [("a", self.operand(&first)?), ("b", self.operand(&second)?), ("weight", weight)];
        Ok(self.computed(texture("mix", entries), mean, entity))
    }

    /// Image at other coordinates than the surface's.
    pub fn placed(&mut self, node: Node, coordinates: Value, entity: &Entity) -> Result<Node> {
        let mean = node.rough_mean();
        let (plain, factor) = match node {
            Node::Image { image, factor } => (Node::Image { image, factor: 1.0 }, factor),
            other => (other, 1.0),
        };
        let bitmap = nested(self.texture(&plain, true)?.with("coordinates", coordinates));
        let value = texture("multiply", [("a", bitmap), ("b", Value::Float(factor))]);
        Ok(self.computed(value, mean, entity))
    }

    /// Texture of the unit square that is 0 beyond it.
    pub fn bordered(&mut self, node: &Node, entity: &Entity) -> Result<Node> {
        let mut value = self.operand(node)?;
        for index in [0, 1] {
            let coordinate = || -> Result<Value> {
                Ok(texture("component", [("value", mappings::of_plane(entity)?), ("index", Value::Integer(index))]))
            };
            let is_outside = [
                texture("less", [("a", coordinate()?), ("b", Value::Float(0.0))]),
                texture("less", [("a", Value::Float(1.0)), ("b", coordinate()?)]),
            ];
            for outside in is_outside {
                let inside = texture("subtract", [("a", Value::Float(1.0)), ("b", outside)]);
                value = texture("multiply", [("a", value), ("b", inside)]);
            }
        }
        Ok(self.computed(value, node.rough_mean(), entity))
    }

    /// Keeps a texture that kernels compute.
    pub fn computed(&mut self, value: Value, mean: DVec3, entity: &Entity) -> Node {
        let place = &entity.parameters.place;
        let id = self.names.id(&format!("texture at line {}", place.line));
        if let Value::Object(object) = value {
            self.objects.push((self.names.label(place, &entity.parameters.owner), object.with_id(id.clone())));
        }
        Node::Computed { id, mean: mean.to_array() }
    }

    /// Input of a texture that kernels compute.
    pub fn operand(&mut self, node: &Node) -> Result<Value> {
        Ok(match node {
            Node::Constant([red, green, blue]) if red == green && red == blue => Value::Float(*red),
            Node::Constant(color) => rgb(*color),
            Node::Computed { id, .. } => Value::Reference(id.clone()),
            Node::Checkerboard { colors: [first, second], to_uv } => {
                let coordinates = mappings::of_map(&(DMat3::from_scale(DVec2::splat(2.0)) * *to_uv));
                let weight = texture("checker", [("coordinates", coordinates)]);
                let [a, b] = [self.operand(&Node::Constant(*first))?, self.operand(&Node::Constant(*second))?];
                texture("mix", [("a", a), ("b", b), ("weight", weight)])
            }
            Node::Image { .. } | Node::Raster { .. } => nested(self.texture(node, true)?),
        })
    }

    /// Function of several textures. Images that lie alike on the surface become one image. For all others, `formula` gives the texture
    /// that kernels compute.
    pub fn combined<const N: usize>(
        &mut self,
        nodes: &[Node; N],
        entity: &Entity,
        function: impl Fn(&[DVec3]) -> DVec3,
        formula: impl FnOnce([Value; N]) -> Value,
    ) -> Result<Node> {
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
        match (&varying[..], varying.first().map(|&first| &nodes[first])) {
            ([], _) => Ok(Node::Constant(with_varying(&[]).to_array())),
            ([_], Some(Node::Checkerboard { colors, to_uv })) => {
                let colors = colors.map(|color| with_varying(&[color.into()]).to_array());
                Ok(Node::Checkerboard { colors, to_uv: *to_uv })
            }
            _ => {
                let Some((rasters, sampling)) = self.rasters(nodes, &varying, entity)? else {
                    let means: Vec<DVec3> = nodes.iter().map(Node::rough_mean).collect();
                    let mut values = Vec::with_capacity(N);
                    for node in nodes {
                        values.push(self.operand(node)?);
                    }
                    let Ok(values) = <[Value; N]>::try_from(values) else { return Ok(nodes[0].clone()) };
                    return Ok(self.computed(formula(values), function(&means), entity));
                };
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

    /// Texels of the textures of these indices, where all are images that lie alike on the surface.
    fn rasters(
        &mut self,
        nodes: &[Node],
        varying: &[usize],
        entity: &Entity,
    ) -> Result<Option<(Vec<Rc<Raster>>, Sampling)>> {
        let sampling_of = |index: &usize| match &nodes[*index] {
            Node::Image { image, .. } => Some(image.sampling),
            Node::Raster { sampling, .. } => Some(*sampling),
            _ => None,
        };
        let Some(sampling) = varying.first().and_then(sampling_of) else { return Ok(None) };
        if varying.iter().any(|index| sampling_of(index) != Some(sampling)) {
            return Ok(None);
        }
        let mut rasters = Vec::with_capacity(varying.len());
        for &index in varying {
            rasters.extend(self.raster(&nodes[index], entity)?.map(|(raster, _)| raster));
        }
        Ok(Some((rasters, sampling)))
    }
}
