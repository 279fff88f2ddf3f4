//! `subsurface`: a dielectric boundary around a medium that light walks through. pbrt renders its diffusion profile in the place of the walk.

use glam::DVec3;

use super::colors;
use super::maker::Maker;
use super::measured_media;
use super::metals;
use super::nodes::{Node, rgb};
use super::parameters::Parameter;
use super::roughness;
use super::tokens::brief;
use crate::Result;
use crate::math::fresnel::fresnel_dielectric;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object};
use crate::scene::description::object::{Object, Value};

/// pbrt's medium, where a file names none: whole milk, per millimeter.
const DEFAULT: ([f64; 3], [f64; 3]) = ([0.0011, 0.0024, 0.014], [2.55, 3.21, 3.77]);
/// Largest single-scattering albedo, so that each walk ends.
const MOST_ALBEDO: f64 = 0.999_999;

/// Reads a `subsurface`: the boundary and the medium within it.
pub(super) fn read(maker: &mut Maker) -> Result<(Object, Object)> {
    let facets = roughness::read(maker, "")?;
    let eta = maker.index("eta", 1.33)?;
    let parameters = &maker.entity.parameters;
    let g = match parameters.get("g") {
        None => 0.0,
        Some(parameter) if parameters.has("name") => {
            if parameter.number()? != 0.0 {
                maker.warn("`g` is ignored beside `name`, as in pbrt: media with names scatter evenly");
            }
            0.0
        }
        Some(parameter) => match parameter.number()? {
            g if g.abs() < 1.0 => g,
            g => return Err(parameter.error(format!("must lie between -1 and 1, but is {g}"))),
        },
    };
    let scale = match parameters.get("scale") {
        None => 1.0,
        Some(parameter) if parameter.number()? < 0.0 => return Err(parameter.error("must not be negative")),
        Some(parameter) => parameter.number()?,
    };
    let (absorption, scattering) = coefficients(maker, eta, g, scale)?;
    let phase = object(Kind::Phase, "hg", [("g", Value::Float(g))]);
    let medium = [("sigma_a", rgb(absorption)), ("sigma_s", rgb(scattering)), ("phase", nested(phase))];
    let medium = object(Kind::Medium, "homogeneous", medium);
    if eta == 1.0 {
        return Ok((object(Kind::Bsdf, "null", []), medium));
    }
    let entries = vec![("int_ior", Value::Float(eta)), ("ext_ior", Value::Float(1.0))];
    Ok((metals::faceted(maker, "dielectric", "roughdielectric", facets, entries)?, medium))
}

/// Coefficients of absorption and of scattering.
fn coefficients(maker: &mut Maker, eta: f64, g: f64, scale: f64) -> Result<([f64; 3], [f64; 3])> {
    let entity = maker.entity;
    let parameters = &entity.parameters;
    let scaled = |(absorption, scattering): ([f64; 3], [f64; 3])| {
        (absorption.map(|channel| channel * scale), scattering.map(|channel| channel * scale))
    };
    if let Some(parameter) = parameters.get("name") {
        let name = parameter.text()?;
        let found = measured_media::named(name);
        return found.map(scaled).ok_or_else(|| {
            parameter.error(format!("names the medium `{}`, which pbrt does not know; check its spelling", brief(name)))
        });
    }
    if let Some(reflectance) = mean(maker, "reflectance")? {
        let path = match mean(maker, "mfp")? {
            Some(path) => path * scale,
            None => DVec3::splat(scale),
        };
        if path.min_element() <= 0.0 {
            return Err(entity.error("`mfp` times `scale` of a `subsurface` must be greater than 0"));
        }
        let extinction = 1.0 / path;
        let albedo = DVec3::from_array(reflectance.to_array().map(|channel| single_albedo(channel, eta, g)));
        return Ok(((extinction * (1.0 - albedo)).to_array(), (extinction * albedo).to_array()));
    }
    if let Some(parameter) = parameters.get("mfp") {
        return Err(parameter.error("of a `subsurface` needs its `reflectance`, too"));
    }
    match (mean(maker, "sigma_a")?, mean(maker, "sigma_s")?) {
        (None, None) => Ok(scaled(DEFAULT)),
        (Some(absorption), Some(scattering)) => Ok(scaled((absorption.to_array(), scattering.to_array()))),
        _ => Err(entity.error("a `subsurface` has both `sigma_a` and `sigma_s`, or neither")),
    }
}

/// Color of a parameter; the mean of a texture, for a medium is the same everywhere.
fn mean(maker: &mut Maker, name: &str) -> Result<Option<DVec3>> {
    let entity = maker.entity;
    let Some(parameter) = entity.parameters.get(name) else { return Ok(None) };
    if parameter.kind != "texture" {
        check_sign(parameter)?;
        let files = &mut *maker.textures.images.files;
        return colors::of_material(parameter, entity.color_space, files).map(|color| Some(color.into()));
    }
    let node = maker.textures.color(&entity.parameters, entity, name, 0.0)?;
    if matches!(node, Node::Constant(_)) {
        return Ok(Some(node.rough_mean()));
    }
    maker.warn(&format!("a texture of `{name}` is taken for its mean: the medium is the same everywhere"));
    let raster = maker.textures.raster(&node, entity)?;
    Ok(Some(raster.map_or(node.rough_mean(), |(raster, _)| raster.mean().as_dvec3())))
}

fn check_sign(parameter: &Parameter) -> Result<()> {
    match parameter.kind == "rgb" && parameter.numbers()?.iter().any(|number| *number < 0.0) {
        true => Err(parameter.error("of a `subsurface` must not be negative")),
        false => Ok(()),
    }
}

/// Single-scattering albedo of a medium that fills a half-space under a dielectric boundary and sends this share of the light that has
/// entered back out. Light from below is reflected by the boundary as often as a diffuse field is (Saunderson 1942). What remains is a boundary
/// that does not reflect, for which d'Eon gives a fit ("A Hitchhiker's Guide to Multiple Scattering", equation 53.7).
fn single_albedo(reflectance: f64, eta: f64, g: f64) -> f64 {
    let r = reflectance.clamp(0.0, 1.0);
    let internal = internal_reflectance(eta);
    let inner = r / (1.0 - internal + internal * r);
    let s = 4.097_12 + 4.208_63 * inner - (9.592_17 + 41.680_8 * inner + 17.712_6 * inner * inner).sqrt();
    ((1.0 - s * s) / (1.0 - g * s * s)).clamp(0.0, MOST_ALBEDO)
}

/// Share of diffuse light from within that the boundary reflects.
fn internal_reflectance(eta: f64) -> f64 {
    const STEPS: u32 = 512;
    let reflected = (0..STEPS).map(|step| {
        let cosine = (f64::from(step) + 0.5) / f64::from(STEPS);
        2.0 * cosine * fresnel_dielectric(cosine, 1.0 / eta).reflectance
    });
    reflected.sum::<f64>() / f64::from(STEPS)
}
