//! Parameters of emitters: light that a color or a texture gives, and factors.

use glam::Vec3;

use super::properties::Properties;
use super::role::Role;
use super::textures::Textures;
use crate::Result;
use crate::scene::texture::Textured;

/// Reads light that a texture or a color gives.
pub(super) fn picture<'a>(
    properties: &mut Properties<'a>,
    name: &str,
    textures: &mut Textures<'a>,
    warnings: &mut Vec<String>,
) -> Result<Textured<Vec3>> {
    match properties.texture(name)? {
        Some(texture) => {
            let found = textures.read(texture, Role::Radiance, warnings)?;
            Ok(Textured { value: found.factor, texture: Some(textures.keep(found.texture)) })
        }
        None => Ok(Textured::constant(color(properties, name)?)),
    }
}

/// Reads a number that is not negative.
pub(super) fn non_negative(properties: &mut Properties, name: &str, default: f32) -> Result<f32> {
    let location = properties.location(name);
    match properties.float(name)? {
        Some(value) if value < 0.0 => Err(location.error(format!("`{name}` must not be negative, as {value} is"))),
        value => Ok(value.unwrap_or(default)),
    }
}

/// Color of emission, 1 in each channel where none is given.
pub(super) fn color(properties: &mut Properties, name: &str) -> Result<Vec3> {
    Ok(properties.emission(name)?.unwrap_or(Vec3::ONE))
}
