//! Tools for making the BSDF of one material.

use super::colors;
use super::nodes::Node;
use super::textures::Textures;
use super::world::Entity;
use crate::Result;
use crate::scene::description::object::Value;

/// Maker of the BSDF of one material.
pub(super) struct Maker<'m, 't, 'w> {
    pub entity: &'m Entity,
    pub textures: &'t mut Textures<'w>,
    pub is_textured: bool,
}

impl Maker<'_, '_, '_> {
    /// Warns about a kind of material, once.
    pub fn warn(&mut self, message: &str) {
        let Entity { kind, parameters, .. } = self.entity;
        self.textures.images.warn(&parameters.place, &format!("material `{kind}`: {message}"));
    }

    /// Color that a parameter gives.
    pub fn color(&mut self, name: &str, default: f64) -> Result<Value> {
        let node = self.textures.color(&self.entity.parameters, self.entity, name, default)?;
        self.value(&node)
    }

    /// Color that a texture gives.
    pub fn value(&mut self, node: &Node) -> Result<Value> {
        self.is_textured |= !matches!(node, Node::Constant(_));
        self.textures.color_value(node)
    }

    /// Number that a texture gives.
    pub fn number(&mut self, node: &Node) -> Result<Value> {
        self.is_textured |= !matches!(node, Node::Constant(_));
        self.textures.number_value(node)
    }

    /// Index of refraction of a dielectric.
    pub fn index(&mut self, name: &str, default: f64) -> Result<f64> {
        let Some(parameter) = self.entity.parameters.get(name) else { return Ok(default) };
        let (index, disperses) = colors::index(parameter, self.textures.images.files)?;
        if disperses {
            self.warn(&format!("dispersion is not rendered; the index of refraction is {index} for all colors"));
        }
        // pbrt takes an index of 0 for 1.
        match index == 0.0 {
            true => Ok(1.0),
            false if index > 0.0 => Ok(index),
            false => Err(parameter.error(format!("must be greater than 0, not {index}"))),
        }
    }
}
