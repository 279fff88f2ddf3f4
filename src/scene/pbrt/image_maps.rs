//! Reader of `imagemap`.

use std::path::Path;
use std::rc::Rc;

use glam::Vec3;

use super::files;
use super::images::Images;
use super::mappings;
use super::nodes::{ImageFile, Node, Source, flipped};
use super::parameters::Parameters;
use super::rasters::{self, Encoding, Sampling};
use super::tokens::brief;
use super::world::Entity;
use crate::Result;
use crate::image::texels::{self, FileTexels};

/// Wrap mode of images that are black beyond their border.
pub(super) const BLACK: &str = "black";

/// Reads an `imagemap`.
pub(super) fn read(images: &mut Images, entity: &Entity, is_number: bool) -> Result<Node> {
    let parameters = &entity.parameters;
    parameters.ignore(&["maxanisotropy"]);
    let name = parameters.text("filename")?;
    let name = name.ok_or_else(|| entity.error("an `imagemap` needs its parameter \"string filename\""))?;
    let filter = match parameters.text("filter")?.unwrap_or("bilinear") {
        "point" => "nearest",
        "bilinear" => "bilinear",
        other @ ("trilinear" | "EWA" | "ewa") => {
            images.warn(&parameters.place, &format!("the filter `{other}` is not supported; `bilinear` is used"));
            "bilinear"
        }
        other => {
            return Err(entity.error(format!("the filter `{}` is not known; use `bilinear` or `point`", brief(other))));
        }
    };
    let wrap = match parameters.text("wrap")?.unwrap_or("repeat") {
        "repeat" => "repeat",
        // Beyond the image, the texture is black by another part of it.
        "clamp" | BLACK => "clamp",
        other => {
            return Err(entity.error(format!(
                "the wrap mode `{}` is not supported; use `repeat`, `clamp` or `black`",
                brief(other)
            )));
        }
    };
    let (factor, is_inverted) = (parameters.number("scale", 1.0)?, parameters.boolean("invert", false)?);
    let encoding = encoding(parameters, name)?;
    let path = images.files.existing(name, "image file", &parameters.place)?;
    let sampling = Sampling { to_uv: flipped(mappings::of_uv(entity)?), wrap, filter };
    let mut image = ImageFile { name: name.to_owned(), source: Source::File(path.clone()), encoding, sampling };
    let mut averages = false;
    if is_number {
        let texels =
            texels::read(&path).map_err(|error| entity.error(format!("the image `{}`: {error}", brief(name))))?;
        match has_alpha(&path)?.then(|| rasters::alpha(&texels)).flatten() {
            Some(alpha) if matches!(alpha.texels, FileTexels::Bytes(_)) => image = images.in_memory(image, alpha)?,
            Some(alpha) => {
                image.source = Source::Memory(Rc::new(alpha));
                averages = true;
            }
            None => averages = !rasters::is_gray(&texels),
        }
    }
    if !averages && !is_inverted && !matches!(encoding, Encoding::Gamma(_)) && factor >= 0.0 {
        return Ok(Node::Image { image, factor });
    }
    let change = |texel: Vec3| {
        let texel = if averages { Vec3::splat(texel.element_sum() / 3.0) } else { texel };
        let scaled = texel * factor as f32;
        if is_inverted { (1.0 - scaled).max(Vec3::ZERO) } else { scaled }
    };
    let raster = images.raster_of(&image, entity)?.map(change);
    images.count(raster.width, raster.height, &parameters.place)?;
    Ok(Node::Raster { raster: Rc::new(raster), sampling })
}

/// Reads the encoding of an image. As in pbrt, it matters to PNG files alone; other files of bytes follow the sRGB curve.
fn encoding(parameters: &Parameters, name: &str) -> Result<Encoding> {
    let given = parameters.text("encoding")?;
    if !Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return Ok(Encoding::Srgb);
    }
    let given = given.unwrap_or("sRGB");
    let gamma =
        || given.strip_prefix("gamma ")?.trim().parse().ok().filter(|gamma: &f64| gamma.is_finite() && *gamma > 0.0);
    match given {
        "sRGB" => Ok(Encoding::Srgb),
        "linear" => Ok(Encoding::Linear),
        _ => gamma().map(Encoding::Gamma).ok_or_else(|| {
            let message = format!("the encoding `{}` is not known; use `sRGB`, `linear` or `gamma 2.2`", brief(given));
            parameters.error(message)
        }),
    }
}

/// Whether a file is a PNG image of red, green, blue and alpha. pbrt reads alpha from no other file with bytes.
fn has_alpha(path: &Path) -> Result<bool> {
    const COLOR_TYPE: usize = 25;
    const RGBA: u8 = 6;
    let (beginning, _) = files::beginning(path, COLOR_TYPE as u64 + 1)?;
    Ok(beginning.starts_with(&[0x89, b'P', b'N', b'G']) && beginning.get(COLOR_TYPE) == Some(&RGBA))
}
