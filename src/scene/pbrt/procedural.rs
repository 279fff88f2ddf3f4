//! Textures that are computed from noise and patterns. pbrt leaves out octaves of noise that are finer than a pixel, and smooths
//! the edges of checkerboards over it; here samples do both.

use glam::{DMat4, DVec3};

use super::mappings::{of_plane, point, texture};
use super::world::Entity;
use crate::Result;
use crate::generated::constants::MAX_OCTAVES;
use crate::scene::description::object::Value;

/// Texture with its approximate mean.
pub(super) type WithMean = (Value, f64);

/// Number of octaves where none is given.
const DEFAULT_OCTAVES: i64 = 8;

/// Texture of a plugin that gives numbers; `None` for other plugins.
pub(super) fn number(entity: &Entity) -> Result<Option<WithMean>> {
    let mean = |value: Value, mean: f64| Ok(Some((value, mean)));
    match entity.kind.as_str() {
        "fbm" => mean(octaves(entity, "fbm", 1.0)?, 0.0),
        "wrinkled" => mean(octaves(entity, "wrinkled", 1.0)?, 0.5),
        "windy" => {
            let strength = noise(entity, "fbm", 0.1, 3, 0.5)?;
            let height = noise(entity, "fbm", 1.0, 6, 0.5)?;
            mean(texture("multiply", [("a", texture("absolute", [("value", strength)])), ("b", height)]), 0.0)
        }
        _ => Ok(None),
    }
}

/// Texture `marble`.
pub(super) fn marble(entity: &Entity) -> Result<WithMean> {
    let parameters = &entity.parameters;
    let scale = parameters.number("scale", 1.0)?;
    let variation = parameters.number("variation", 0.2)?;
    let place = point(entity, &DMat4::from_scale(DVec3::splat(scale)))?;
    let height = texture("component", [("value", place), ("index", Value::Integer(1))]);
    let turbulence = texture("multiply", [("a", octaves(entity, "fbm", scale)?), ("b", Value::Float(variation))]);
    let wave = texture("sine", [("value", texture("add", [("a", height), ("b", turbulence)]))]);
    let share = texture("mix", [("a", Value::Float(1.0)), ("b", wave), ("weight", Value::Float(0.5))]);
    Ok((texture("marble_color", [("value", share)]), 0.8))
}

/// Weight of the second part of a texture that chooses between two; `None` for other textures.
pub(super) fn weight(entity: &Entity) -> Result<Option<WithMean>> {
    let parameters = &entity.parameters;
    Ok(Some(match entity.kind.as_str() {
        "checkerboard" => {
            let coordinates = match parameters.integer("dimension", 2..=3)? {
                Some(3) => point(entity, &DMat4::IDENTITY)?,
                _ => of_plane(entity)?,
            };
            (texture("checker", [("coordinates", coordinates)]), 0.5)
        }
        "dots" => (texture("dots", [("coordinates", of_plane(entity)?)]), 0.19),
        "directionmix" => {
            let direction = parameters.point("dir")?.map_or(DVec3::Y, DVec3::from);
            let direction = entity.to_world.matrix.transform_vector3(direction).try_normalize();
            let direction =
                direction.ok_or_else(|| entity.error("`dir` of a `directionmix` must have a length above 0"))?;
            let cosine = texture("dot", [("a", texture("normal", [])), ("b", Value::Vector(direction.to_array()))]);
            (texture("absolute", [("value", cosine)]), 0.5)
        }
        _ => return Ok(None),
    }))
}

/// Mix of four values by the coordinates: `v00`, `v10`, `v01` and `v11`.
pub(super) fn bilerp(entity: &Entity, [v00, v10, v01, v11]: [Value; 4]) -> Result<Value> {
    let coordinate = |index| Ok(texture("component", [("value", of_plane(entity)?), ("index", Value::Integer(index))]));
    let mix = |a, b, weight| texture("mix", [("a", a), ("b", b), ("weight", weight)]);
    Ok(mix(mix(v00, v10, coordinate(0)?), mix(v01, v11, coordinate(0)?), coordinate(1)?))
}

/// Octaves of noise with the parameters of the texture.
fn octaves(entity: &Entity, plugin: &'static str, scale: f64) -> Result<Value> {
    let parameters = &entity.parameters;
    let octaves = parameters.integer("octaves", 0..=i64::from(MAX_OCTAVES))?.unwrap_or(DEFAULT_OCTAVES);
    let roughness = parameters.number("roughness", 0.5)?;
    noise(entity, plugin, scale, octaves, roughness)
}

/// Octaves of noise in the texture's space after a scale.
fn noise(entity: &Entity, plugin: &'static str, scale: f64, octaves: i64, roughness: f64) -> Result<Value> {
    let place = point(entity, &DMat4::from_scale(DVec3::splat(scale)))?;
    Ok(texture(
        plugin,
        [("coordinates", place), ("octaves", Value::Integer(octaves)), ("roughness", Value::Float(roughness))],
    ))
}
