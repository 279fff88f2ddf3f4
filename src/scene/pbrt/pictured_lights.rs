//! Lights at a point whose intensity an image gives: `projection` and `goniometric`. They become spots that throw pictures.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use glam::{DMat3, DMat4, DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::delta_lights::{color, power};
use super::equal_area::square_from_direction;
use super::images::Images;
use super::nodes::{planar, rgb};
use super::rasters::{Encoding, Raster};
use super::tokens::{Place, brief};
use super::transforms::rigid;
use super::world::Entity;
use crate::Result;
use crate::image::{exr, texels};
use crate::math::srgb::luminance;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{matrix, nested, object};
use crate::scene::description::object::{Object, Value};

/// Fewest and most texels along the sides of the six pictures of a `goniometric` light.
const SIDES: [usize; 2] = [32, 1024];
/// Points along each side of such a texel at which the light's image is looked up.
const POINTS: usize = 4;

/// Spot that throws the light's image. pbrt's image fills a pyramid around the light's `+z`, with its top at `+y` and its left at `-x`.
pub(super) fn projection(entity: &Entity, exposure: f64, images: &mut Images) -> Result<Vec<Object>> {
    let parameters = &entity.parameters;
    parameters.ignore(&["I"]);
    let fov = parameters.number("fov", 90.0)?;
    if !(fov > 0.0 && fov < 180.0) {
        return Err(entity.error(format!("`fov` must lie between 0 and 180 degrees, not {fov}")));
    }
    let image = image(entity, images)?;
    let (width, height) = (image.width as f64, image.height as f64);
    let half = DVec2::new((width / height).max(1.0), (height / width).max(1.0)) * (0.5 * fov).to_radians().tan();
    let emitted = {
        let texel = |at: usize, color: &Vec3| {
            let place = DVec2::new((at % image.width) as f64 + 0.5, (at / image.width) as f64 + 0.5);
            let cosine = ((2.0 * place / DVec2::new(width, height) - 1.0) * half).extend(1.0).length_recip();
            luminance(color.as_dvec3().to_array()) * cosine.powi(3)
        };
        let sum: f64 = image.texels.iter().enumerate().map(|(at, color)| texel(at, color)).sum();
        4.0 * half.x * half.y * sum / (width * height)
    };
    let intensity = color(entity, "", exposure * power(entity, emitted)?, images.files)?;
    let pose = pose(entity)?;
    Ok(vec![spot(&image, half, &pose, intensity, &entity.parameters.place, images)?])
}

/// Six spots, one for each side of a cube around the light. pbrt's image is an equal-area map whose `+z` is the light's `+y`.
pub(super) fn goniometric(entity: &Entity, exposure: f64, images: &mut Images) -> Result<Vec<Object>> {
    let image = image(entity, images)?;
    let (side, height) = (image.width, image.height);
    if side != height {
        let message =
            format!("the image of the light has {side}x{height} pixels, but pbrt-v4's are square, equal-area maps");
        return Err(entity.error(message));
    }
    let image = image.map(|texel| Vec3::splat(texel.element_sum() / 3.0));
    let mean = f64::from(image.mean().x);
    let intensity = color(entity, "I", exposure * power(entity, 4.0 * PI * mean)?, images.files)?;
    let pose = pose(entity)?;
    images.warn(
        &entity.parameters.place,
        "a `goniometric` light is read as six spots with square pictures; each texel of theirs is the mean of the light's image over it",
    );
    let texels = (2 * side).clamp(SIDES[0], SIDES[1]);
    let look_up = |direction: DVec3| {
        let at = square_from_direction(DVec3::new(direction.x, direction.z, direction.y).normalize()) * side as f64;
        let index = |at: f64| (at as usize).min(side - 1);
        image.texels[index(at.y) * side + index(at.x)]
    };
    let mut lights = Vec::new();
    for axis in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
        let (x, y) = axis.any_orthonormal_pair();
        let face = face(texels, |at| look_up(axis + at.x * x + at.y * y));
        if face.texels.iter().all(|texel| *texel == Vec3::ZERO) {
            continue;
        }
        let turn = DMat4::from_cols(x.extend(0.0), y.extend(0.0), axis.extend(0.0), glam::DVec4::W);
        lights.push(spot(&face, DVec2::ONE, &(pose * turn), intensity, &entity.parameters.place, images)?);
    }
    Ok(lights)
}

/// Picture of a function of the place in the square from -1 to 1, with `+y` at its top. Each texel is the mean of several places.
fn face(side: usize, look_up: impl Fn(DVec2) -> Vec3 + Sync) -> Raster {
    let step = 2.0 / (side * POINTS) as f64;
    let texel = |at: usize| {
        let corner = DVec2::new((at % side * POINTS) as f64, (at / side * POINTS) as f64);
        let place = |point: usize| {
            let at = (corner + DVec2::new((point % POINTS) as f64, (point / POINTS) as f64) + 0.5) * step - 1.0;
            DVec2::new(at.x, -at.y)
        };
        (0..POINTS * POINTS).map(|point| look_up(place(point))).sum::<Vec3>() / (POINTS * POINTS) as f32
    };
    Raster { width: side, height: side, texels: (0..side * side).into_par_iter().map(texel).collect() }
}

/// Spot that throws an image into the pyramid whose cross section at the distance 1 has these half widths.
fn spot(
    image: &Raster,
    half: DVec2,
    pose: &DMat4,
    intensity: [f64; 3],
    place: &Place,
    images: &mut Images,
) -> Result<Object> {
    // A border of black texels, which go on beyond it.
    let (width, height) = (image.width + 2, image.height + 2);
    let texel = |at: usize| {
        let (x, y) = (at % width, at / width);
        let is_inside = (1..=image.width).contains(&x) && (1..=image.height).contains(&y);
        if is_inside { image.texels[(y - 1) * image.width + x - 1] } else { Vec3::ZERO }
    };
    let bordered = Raster { width, height, texels: (0..width * height).map(texel).collect() };
    images.count(width, height, place)?;
    let name = images.new_name("picture", "exr");
    images.add_file(name.clone(), exr::encode_rgb(Path::new(&name), &bordered.to_image())?);
    // The whole image lies in the beam.
    let corner = half.length().atan();
    let (beam, cutoff) = (corner + 0.25 * (FRAC_PI_2 - corner), corner + 0.5 * (FRAC_PI_2 - corner));
    let inner = DVec2::new(image.width as f64 / width as f64, image.height as f64 / height as f64);
    let scale = cutoff.tan() / half * inner * DVec2::new(1.0, -1.0);
    let centered = |offset: f64| DMat3::from_translation(DVec2::splat(offset));
    let to_uv = centered(0.5) * DMat3::from_scale(scale) * centered(-0.5);
    let text = |text: &str| Value::Text(text.to_owned());
    let entries = [
        ("filename", images.value(name)),
        ("raw", Value::Boolean(true)),
        ("wrap_mode", text("clamp")),
        ("filter_type", text("nearest")),
        ("to_uv", planar(&to_uv)),
    ];
    let picture = object(Kind::Texture, "bitmap", entries);
    let entries = [
        ("to_world", matrix(pose)),
        ("intensity", rgb(intensity)),
        ("cutoff_angle", Value::Float(cutoff.to_degrees())),
        ("beam_width", Value::Float(beam.to_degrees())),
        ("texture", nested(picture)),
    ];
    Ok(object(Kind::Emitter, "spot", entries))
}

/// Image of a light, in linear sRGB.
fn image(entity: &Entity, images: &mut Images) -> Result<Raster> {
    let name = entity.parameters.text("filename")?;
    let name = name.ok_or_else(|| entity.error("the light needs its parameter \"string filename\""))?;
    let path = images.files.existing(name, "image file", &entity.parameters.place)?;
    let fault = |message: String| entity.error(format!("the image `{}` of the light {message}", brief(name)));
    let image = texels::read(&path).map_err(|error| fault(format!("cannot be read: {error}")))?;
    let raster = Raster::of(&image.in_srgb(), Encoding::Srgb);
    images.count(raster.width, raster.height, &entity.parameters.place)?;
    match raster.texels.iter().all(|texel| texel.is_finite()) {
        true => Ok(raster.map(|texel| texel.max(Vec3::ZERO))),
        false => Err(fault("has a pixel that is no finite number".to_owned())),
    }
}

fn pose(entity: &Entity) -> Result<DMat4> {
    let pose = rigid(&entity.to_world.matrix);
    pose.map(|(pose, _)| pose)
        .ok_or_else(|| entity.error("the transform of a light with an image must neither shear nor scale unevenly"))
}
