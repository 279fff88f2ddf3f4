//! Infinite lights.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3, DVec4, Vec3};
use rayon::prelude::*;

use super::delta_lights::color;
use super::equal_area::{direction_of_texel, rolled, square_from_direction, unrolled};
use super::nodes::rgb;
use super::rasters::{Encoding, Raster};
use super::textures::Textures;
use super::tokens::brief;
use super::transforms::rigid;
use super::world::Entity;
use crate::Result;
use crate::image::exr;
use crate::image::texels;
use crate::math::srgb::luminance;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, object};
use crate::scene::description::object::{Object, Value};

/// Emitter of the sum of a scene's infinite lights; `None` where there are none. `exposure` is a factor of all light.
pub(super) fn of_lights(lights: &[&Entity], exposure: f64, textures: &mut Textures) -> Result<Option<Object>> {
    let (mut radiance, mut map) = ([0.0; 3], None::<Map>);
    for entity in lights {
        match light(entity, exposure, textures)? {
            Infinite::Constant(color) => (0..3).for_each(|channel| radiance[channel] += color[channel]),
            Infinite::Map(found) => {
                map = Some(match map {
                    None => found,
                    Some(map) => Map::sum(map, found),
                });
            }
        }
    }
    // The other lights are added to the map's texels, and a scale of 0 would hide them.
    let Some(Map { mut raster, scale, to_world }) = map.filter(|map| map.scale > 0.0) else {
        let constant = || object(Kind::Emitter, "constant", [("radiance", rgb(radiance))]);
        return Ok((!lights.is_empty()).then(constant));
    };
    if radiance != [0.0; 3] {
        let more = (DVec3::from(radiance) / scale).as_vec3();
        raster.texels.iter_mut().for_each(|texel| *texel += more);
    }
    let name = textures.images.new_name("environment", "exr");
    textures.images.add_file(name.clone(), exr::encode_rgb(std::path::Path::new(&name), &raster.to_image())?);
    let entries =
        [("filename", textures.images.value(name)), ("scale", Value::Float(scale)), ("to_world", matrix(&to_world))];
    Ok(Some(object(Kind::Emitter, "envmap", entries)))
}

/// Infinite light.
enum Infinite {
    Constant([f64; 3]),
    Map(Map),
}

/// Map of longitude and latitude, the factor of its colors, and its place.
struct Map {
    raster: Raster,
    scale: f64,
    to_world: DMat4,
}

impl Map {
    /// Sum of two maps, with the place of the larger one. Where the texels of the other lie elsewhere, it is interpolated.
    fn sum(one: Self, other: Self) -> Self {
        let is_larger = other.raster.texels.len() > one.raster.texels.len();
        let (mut one, other) = if is_larger { (other, one) } else { (one, other) };
        let is_alike = one.raster.texels.len() == other.raster.texels.len() && one.to_world == other.to_world;
        let (scale, more) = (one.scale as f32, other.scale as f32);
        let (width, height) = (one.raster.width, one.raster.height);
        let other_from_one = other.to_world.inverse() * one.to_world;
        one.raster.texels.par_iter_mut().enumerate().for_each(|(at, texel)| {
            let added = match is_alike {
                true => other.raster.texels[at],
                false => {
                    let direction = direction_of_texel(at % width, at / width, width, height);
                    interpolated(&other.raster, other_from_one.transform_vector3(direction))
                }
            };
            *texel = *texel * scale + added * more;
        });
        Self { scale: 1.0, ..one }
    }
}

fn light(entity: &Entity, exposure: f64, textures: &mut Textures) -> Result<Infinite> {
    let parameters = &entity.parameters;
    if let Some(portal) = parameters.get("portal") {
        let message = "the `portal` of an infinite light is ignored; its light comes through every opening";
        textures.images.warn(&portal.place, message);
    }
    if parameters.has("mapname") {
        return old_map(entity, exposure, textures);
    }
    let illuminance = parameters.number("illuminance", -1.0)?;
    let factor = |of_one: f64| if illuminance > 0.0 { exposure * illuminance / of_one } else { exposure };
    let Some(name) = parameters.text("filename")? else {
        return Ok(Infinite::Constant(color(entity, "L", factor(PI), textures.images.files)?));
    };
    if let Some(radiance) = parameters.get("L") {
        return Err(radiance.error("cannot stand beside `filename`; give one of them"));
    }
    let path = textures.images.files.existing(name, "image file", &parameters.place)?;
    let image = texels::read(&path).map_err(|error| entity.error(format!("the image of the light: {error}")))?;
    let (width, height) = (image.width, image.height);
    if width != height {
        return Err(entity.error(format!(
            "the image `{}` has {width}x{height} pixels, but pbrt-v4's are square; `imgtool makeequiarea` makes them of maps of \
             longitude and latitude",
            brief(name)
        )));
    }
    let light = |texel: Vec3| if texel.is_finite() { texel.max(Vec3::ZERO) } else { Vec3::ZERO };
    let square = Raster::of(&image, Encoding::Srgb).map(light);
    let of_one = if illuminance > 0.0 { illuminance_of(&square) } else { 1.0 };
    let [scale, ..] = color(entity, "L", factor(if of_one > 0.0 { of_one } else { 1.0 }), textures.images.files)?;
    Ok(Infinite::Map(Map { raster: unrolled(&square), scale, to_world: upright(entity)? }))
}

/// Map of pbrt-v3: an image of longitude and latitude whose uppermost row is the light's `+z`. `L` is a factor of its colors.
fn old_map(entity: &Entity, exposure: f64, textures: &mut Textures) -> Result<Infinite> {
    let parameters = &entity.parameters;
    let name = parameters.text("mapname")?.unwrap_or_default();
    let path = textures.images.files.existing(name, "image file", &parameters.place)?;
    let image = texels::read(&path).map_err(|error| entity.error(format!("the image of the light: {error}")))?;
    let factor = DVec3::from(color(entity, "L", exposure, textures.images.files)?);
    let light = |texel: Vec3| if texel.is_finite() { texel.max(Vec3::ZERO) } else { Vec3::ZERO };
    let image = Raster::of(&image, Encoding::Srgb).map(|texel| light(texel) * factor.as_vec3());
    let raster = rolled(image.width, |direction| {
        let (azimuth, polar) = (direction.y.atan2(direction.x).rem_euclid(TAU), direction.z.clamp(-1.0, 1.0).acos());
        let index = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
        image.texels[index(polar / PI, image.height) * image.width + index(azimuth / TAU, image.width)].as_dvec3()
    });
    Ok(Infinite::Map(Map { raster, scale: 1.0, to_world: upright(entity)? }))
}

/// Place of a map whose `+y` is the light's `+z`.
fn upright(entity: &Entity) -> Result<DMat4> {
    let (turn, _) = rigid(&entity.to_world.matrix)
        .ok_or_else(|| entity.error("the transform of an infinite light must neither shear nor scale unevenly"))?;
    let mut to_world = turn * DMat4::from_cols(DVec4::X, DVec4::Z, -DVec4::Y, DVec4::W);
    to_world.w_axis = DVec4::W;
    Ok(to_world)
}

/// Color of a map of longitude and latitude in a direction of its space, between the centers of its texels.
fn interpolated(map: &Raster, direction: DVec3) -> Vec3 {
    let direction = direction.normalize_or(DVec3::Y);
    let azimuth = direction.x.atan2(-direction.z).rem_euclid(TAU);
    let (x, y) =
        (azimuth / TAU * map.width as f64 - 0.5, direction.y.clamp(-1.0, 1.0).acos() / PI * (map.height - 1) as f64);
    let (left, top) = (x.floor(), (y as usize).min(map.height - 1));
    let below = (top + 1).min(map.height - 1);
    let column = |offset: f64| (left + offset).rem_euclid(map.width as f64) as usize % map.width;
    let row = |row: usize| {
        let texel = |column: usize| map.texels[row * map.width + column];
        texel(column(0.0)).lerp(texel(column(1.0)), (x - left) as f32)
    };
    row(top).lerp(row(below), (y - top as f64) as f32)
}

/// Illuminance of a square map on a surface that faces its `+z`.
fn illuminance_of(square: &Raster) -> f64 {
    const STEPS: usize = 512;
    // Midpoints in the squared sine of the angle and in the azimuth, which weighs each by its cosine.
    let mut sum = 0.0;
    for row in 0..STEPS {
        let sine = ((row as f64 + 0.5) / STEPS as f64).sqrt();
        for column in 0..STEPS {
            let azimuth = glam::DVec2::from_angle((column as f64 + 0.5) / STEPS as f64 * 2.0 * PI);
            let at = square_from_direction((sine * azimuth).extend((1.0 - sine * sine).sqrt())) * square.width as f64;
            let index = |at: f64| (at as usize).min(square.width - 1);
            sum += luminance(square.texels[index(at.y) * square.width + index(at.x)].as_dvec3().to_array());
        }
    }
    PI * sum / (STEPS * STEPS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Map of a smooth function of the direction in the world.
    fn map(width: usize, scale: f64, to_world: DMat4, function: impl Fn(DVec3) -> DVec3) -> Map {
        let height = width / 2 + 1;
        let texel = |at: usize| {
            let own = direction_of_texel(at % width, at / width, width, height);
            (function(to_world.transform_vector3(own)) / scale).as_vec3()
        };
        let texels = (0..width * height).map(texel).collect();
        Map { raster: Raster { width, height, texels }, scale, to_world }
    }

    /// The sum of two maps of other sizes, places and scales is the sum of their functions in each direction of the world.
    #[test]
    fn maps_in_other_places_add_up() {
        let one = |d: DVec3| DVec3::new(2.0 + d.x, 1.0 + d.y * d.y, 1.5 + d.z);
        let other = |d: DVec3| DVec3::new(1.0 - 0.5 * d.z, 2.0 + d.x * d.y, 1.0);
        let turned =
            DMat4::from_rotation_y(0.7) * DMat4::from_rotation_x(1.1) * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        for (small, large) in [(DMat4::IDENTITY, turned), (turned, DMat4::IDENTITY), (turned, turned)] {
            for is_first in [true, false] {
                let maps = (map(64, 2.0, small, one), map(96, 0.25, large, other));
                let sum = if is_first { Map::sum(maps.0, maps.1) } else { Map::sum(maps.1, maps.0) };
                assert_eq!((sum.raster.width, sum.to_world), (96, large));
                for (at, texel) in sum.raster.texels.iter().enumerate() {
                    let own = direction_of_texel(at % 96, at / 96, 96, sum.raster.height);
                    let world = large.transform_vector3(own);
                    let right = (one(world) + other(world)) / sum.scale;
                    assert!((texel.as_dvec3() - right).length() < 0.01, "{at}: {texel} is not {right}");
                }
            }
        }
    }
}
