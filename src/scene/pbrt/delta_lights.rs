//! Lights at a point or from one direction.

use glam::{DMat4, DVec3};
use std::f64::consts::{PI, TAU};

use super::colors;
use super::files::Files;
use super::nodes::rgb;
use super::tokens::brief;
use super::world::Entity;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, object};
use crate::scene::description::object::{Object, Value};

/// Emitter of a light. `exposure` is a factor of all light.
pub(super) fn light(entity: &Entity, exposure: f64, files: &mut Files, warnings: &mut Vec<String>) -> Result<Object> {
    match entity.kind.as_str() {
        "point" => {
            let position = world_point(entity, point(entity, "from", DVec3::ZERO)?);
            let intensity = color(entity, "I", exposure * power(entity, 4.0 * PI)?, files)?;
            Ok(object(Kind::Emitter, "point", [("position", vector(position)), ("intensity", rgb(intensity))]))
        }
        "spot" => spot(entity, exposure, files, warnings),
        "distant" => {
            let (from, to) = (point(entity, "from", DVec3::ZERO)?, point(entity, "to", DVec3::Z)?);
            let direction = entity.to_world.matrix.transform_vector3(to - from).try_normalize();
            let direction = direction.ok_or_else(|| entity.error("`from` and `to` of a distant light must differ"))?;
            let illuminance = entity.parameters.number("illuminance", -1.0)?;
            let factor = if illuminance > 0.0 { exposure * illuminance } else { exposure };
            let irradiance = color(entity, "L", factor, files)?;
            Ok(object(
                Kind::Emitter,
                "directional",
                [("direction", vector(direction)), ("irradiance", rgb(irradiance))],
            ))
        }
        other => Err(entity.error(format!("the light `{}` is not known; check its spelling", brief(other)))),
    }
}

fn spot(entity: &Entity, exposure: f64, files: &mut Files, warnings: &mut Vec<String>) -> Result<Object> {
    let parameters = &entity.parameters;
    let (from, to) = (point(entity, "from", DVec3::ZERO)?, point(entity, "to", DVec3::Z)?);
    let (cone, delta) = (parameters.positive("coneangle", 30.0)?, parameters.number("conedeltaangle", 5.0)?);
    let beam = cone - delta;
    if !(cone <= 180.0 && (0.0..=cone).contains(&beam)) {
        return Err(entity.error("a spot needs a `coneangle` of at most 180 degrees, and a `conedeltaangle` within it"));
    }
    if delta > 0.0 {
        let message = "the light of a spot fades linearly with the angle, not by pbrt's smooth step";
        warnings.push(format!("{}: {message}", parameters.place));
    }
    let (cosine_beam, cosine_cone) = (beam.to_radians().cos(), cone.to_radians().cos());
    // pbrt's normalization.
    let emitted = TAU * ((1.0 - cosine_beam) + 0.5 * (cosine_beam - cosine_cone));
    let intensity = color(entity, "I", exposure * power(entity, emitted)?, files)?;
    let from = world_point(entity, from);
    let axis = (world_point(entity, to) - from).try_normalize();
    let axis = axis.ok_or_else(|| entity.error("`from` and `to` of a spot must differ"))?;
    let (x, y) = axis.any_orthonormal_pair();
    let pose = DMat4::from_cols(x.extend(0.0), y.extend(0.0), axis.extend(0.0), from.extend(1.0));
    let entries = [
        ("to_world", matrix(&pose)),
        ("intensity", rgb(intensity)),
        ("cutoff_angle", Value::Float(cone)),
        ("beam_width", Value::Float(beam)),
    ];
    Ok(object(Kind::Emitter, "spot", entries))
}

/// Factor that gives a light its `power`, where it is given. `emitted` is the power of a light of intensity 1.
pub(super) fn power(entity: &Entity, emitted: f64) -> Result<f64> {
    let power = entity.parameters.number("power", -1.0)?;
    Ok(if power > 0.0 { power / emitted } else { 1.0 })
}

/// Color of a light times its `scale` and a factor.
pub(super) fn color(entity: &Entity, name: &str, factor: f64, files: &mut Files) -> Result<[f64; 3]> {
    let scale = factor * entity.parameters.number("scale", 1.0)?;
    if scale < 0.0 {
        return Err(entity.error(format!("the light's `scale` must not be negative, as {scale} is")));
    }
    let color = match entity.parameters.get(name) {
        Some(parameter) => colors::of_light(parameter, entity.color_space, files)?,
        None => [1.0; 3],
    };
    Ok(color.map(|channel| channel * scale))
}

fn point(entity: &Entity, name: &str, default: DVec3) -> Result<DVec3> {
    Ok(entity.parameters.point(name)?.map_or(default, DVec3::from))
}

fn world_point(entity: &Entity, point: DVec3) -> DVec3 {
    entity.to_world.matrix.transform_point3(point)
}

fn vector(vector: DVec3) -> Value {
    Value::Vector(vector.to_array())
}
