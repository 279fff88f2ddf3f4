//! Coordinates of textures: mappings of the plane, and points in a texture's own space.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::nodes::planar;
use super::tokens::brief;
use super::world::Entity;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, nested, object};
use crate::scene::description::object::Value;

/// Nested texture of that plugin.
pub(super) fn texture<const N: usize>(plugin: &'static str, entries: [(&'static str, Value); N]) -> Value {
    nested(object(Kind::Texture, plugin, entries))
}

/// Reads the mapping from the surface's coordinates to the texture's; no change where another mapping is named.
pub(super) fn of_uv(entity: &Entity) -> Result<DMat3> {
    let parameters = &entity.parameters;
    if !matches!(parameters.text("mapping")?, None | Some("uv")) {
        return Ok(DMat3::IDENTITY);
    }
    let scale = DVec2::new(parameters.number("uscale", 1.0)?, parameters.number("vscale", 1.0)?);
    let offset = DVec2::new(parameters.number("udelta", 0.0)?, parameters.number("vdelta", 0.0)?);
    Ok(DMat3::from_translation(offset) * DMat3::from_scale(scale))
}

/// Reads the mapping of a texture of the plane; `None` where it is that of [`of_uv`].
pub(super) fn of_position(entity: &Entity) -> Result<Option<Value>> {
    let parameters = &entity.parameters;
    let plane = |plugin| Ok(Some(texture(plugin, [("coordinates", point(entity, &DMat4::IDENTITY)?)])));
    match parameters.text("mapping")? {
        None | Some("uv") => Ok(None),
        Some("spherical") => plane("spherical"),
        Some("cylindrical") => plane("cylindrical"),
        Some("planar") => {
            let axis = |name: &str, default: DVec3| Ok(parameters.point(name)?.map_or(default, DVec3::from));
            let (u, v) = (axis("v1", DVec3::X)?, axis("v2", DVec3::Y)?);
            let (du, dv) = (parameters.number("udelta", 0.0)?, parameters.number("vdelta", 0.0)?);
            let rows = DMat4::from_cols(u.extend(du), v.extend(dv), DVec4::ZERO, DVec4::W);
            point(entity, &rows.transpose()).map(Some)
        }
        Some(other) => {
            let message = format!(
                "the mapping `{}` is not known; use `uv`, `spherical`, `cylindrical` or `planar`",
                brief(other)
            );
            Err(entity.error(message))
        }
    }
}

/// Coordinates of a texture of the plane.
pub(super) fn of_plane(entity: &Entity) -> Result<Value> {
    match of_position(entity)? {
        Some(coordinates) => Ok(coordinates),
        None => Ok(of_map(&of_uv(entity)?)),
    }
}

/// Coordinates of the surface after a map.
pub(super) fn of_map(map: &DMat3) -> Value {
    match *map == DMat3::IDENTITY {
        true => texture("uv", []),
        false => texture("transformed", [("to_texture", planar(map))]),
    }
}

/// The position in the texture's space, which holds where the texture stands in the file, after another affine map.
pub(super) fn point(entity: &Entity, then: &DMat4) -> Result<Value> {
    let map = *then * entity.to_world.inverse;
    if !map.is_finite() {
        return Err(entity.error("the transform at this texture flattens everything; it has no space of its own"));
    }
    let position = texture("position", []);
    Ok(match map == DMat4::IDENTITY {
        true => position,
        false => texture("transformed", [("coordinates", position), ("to_texture", matrix(&map))]),
    })
}
