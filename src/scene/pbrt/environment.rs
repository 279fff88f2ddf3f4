//! Infinite lights.

use std::f64::consts::PI;

use glam::{DMat4, DVec4};

use super::delta_lights::color;
use super::equal_area::{square_from_direction, unrolled};
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
                    Some(map) => Map::sum(map, found).ok_or_else(|| {
                        entity.error(
                            "a second infinite light whose image has another size or place; add the images in one",
                        )
                    })?,
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
        let more = (glam::DVec3::from(radiance) / scale).as_vec3();
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
    /// Sum of two maps; `None` where their texels do not lie at the same places.
    fn sum(mut one: Self, other: Self) -> Option<Self> {
        if one.raster.texels.len() != other.raster.texels.len() || one.to_world != other.to_world {
            return None;
        }
        let scales = (one.scale as f32, other.scale as f32);
        for (texel, more) in one.raster.texels.iter_mut().zip(other.raster.texels) {
            *texel = *texel * scales.0 + more * scales.1;
        }
        Some(Self { scale: 1.0, ..one })
    }
}

fn light(entity: &Entity, exposure: f64, textures: &mut Textures) -> Result<Infinite> {
    let parameters = &entity.parameters;
    if let Some(portal) = parameters.get("portal") {
        let message = "the `portal` of an infinite light is ignored; its light comes through every opening";
        textures.images.warn(&portal.place, message);
    }
    if let Some(map) = parameters.get("mapname") {
        return Err(map.error("belongs to pbrt-v3; `pbrt --upgrade` makes a file of v4, which is read"));
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
    let light = |texel: glam::Vec3| if texel.is_finite() { texel.max(glam::Vec3::ZERO) } else { glam::Vec3::ZERO };
    let square = Raster::of(&image, Encoding::Srgb).map(light);
    let of_one = if illuminance > 0.0 { illuminance_of(&square) } else { 1.0 };
    let [scale, ..] = color(entity, "L", factor(if of_one > 0.0 { of_one } else { 1.0 }), textures.images.files)?;
    let (turn, _) = rigid(&entity.to_world.matrix)
        .ok_or_else(|| entity.error("the transform of an infinite light must neither shear nor scale unevenly"))?;
    // The map's +y is the light's +z.
    let upright = DMat4::from_cols(DVec4::X, DVec4::Z, -DVec4::Y, DVec4::W);
    let mut to_world = turn * upright;
    to_world.w_axis = DVec4::W;
    Ok(Infinite::Map(Map { raster: unrolled(&square), scale, to_world }))
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
