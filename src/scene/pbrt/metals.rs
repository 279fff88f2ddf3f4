//! Conductors, and BSDFs that are smooth or rough.

use super::colors;
use super::maker::Maker;
use super::named_spectra;
use super::nodes::{Node, rgb};
use super::parameters::Parameter;
use super::roughness::Facets;
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::object;
use crate::scene::description::object::{Object, Value};

/// Parameters of a plugin.
pub(super) type Entries = Vec<(&'static str, Value)>;

/// Parameters of a conductor under a medium of the index `outside`.
pub(super) fn metal(maker: &mut Maker, names: [&str; 2], outside: f64) -> Result<Entries> {
    let entity = maker.entity;
    let parameters = &entity.parameters;
    let given = names.iter().find_map(|name| parameters.get(name));
    if let Some(reflectance) = parameters.get("reflectance") {
        if let Some(given) = given {
            return Err(given.error("cannot stand beside `reflectance`; give one of them"));
        }
        return reflecting(maker, reflectance, outside);
    }
    let mut spectrum = |name: &str, default: &str| match parameters.get(name) {
        Some(parameter) if parameter.kind == "texture" => match maker.textures.color(parameters, entity, name, 1.0)? {
            Node::Constant(color) => Ok(color),
            _ => Err(parameter.error("of a conductor must be one color, not a texture")),
        },
        Some(parameter) => colors::of_material(parameter, entity.color_space, maker.textures.images.files),
        None => Ok(named_spectra::of_material(default).unwrap_or([1.0; 3])),
    };
    let (eta, k) = (spectrum(names[0], "metal-Cu-eta")?, spectrum(names[1], "metal-Cu-k")?);
    // Mitsuba 3 knows no medium outside of a conductor.
    let relative = |color: [f64; 3]| rgb(color.map(|channel| channel / outside));
    Ok(vec![("eta", relative(eta)), ("k", relative(k))])
}

/// Parameters of a conductor that reflects a color where it is met at a right angle: its index of refraction is 1.
fn reflecting(maker: &mut Maker, reflectance: &Parameter, outside: f64) -> Result<Entries> {
    let entity = maker.entity;
    match maker.textures.color(&entity.parameters, entity, "reflectance", 1.0)? {
        Node::Constant(color) => {
            let k = color.map(|channel| {
                let channel = channel.clamp(0.0, 0.9999);
                2.0 * channel.sqrt() / (1.0 - channel).sqrt()
            });
            Ok(vec![("eta", rgb([1.0 / outside; 3])), ("k", rgb(k.map(|channel| channel / outside)))])
        }
        node => {
            let place = &reflectance.place;
            let message = "a conductor whose reflectance is a texture reflects the same color at all angles";
            maker.textures.images.warn(place, message);
            Ok(vec![("specular_reflectance", maker.value(&node)?)])
        }
    }
}

/// Smooth or rough BSDF with its parameters.
pub(super) fn faceted(
    maker: &mut Maker,
    smooth: &'static str,
    rough: &'static str,
    facets: Facets,
    entries: Entries,
) -> Result<Object> {
    let (plugin, mut bsdf) = match facets {
        Facets::Smooth => (smooth, object(Kind::Bsdf, smooth, [])),
        Facets::Even(alpha) => (rough, object(Kind::Bsdf, rough, [("alpha", maker.number(&alpha)?)])),
        Facets::Uneven([u, v]) => {
            (rough, object(Kind::Bsdf, rough, [("alpha_u", maker.number(&u)?), ("alpha_v", maker.number(&v)?)]))
        }
    };
    if plugin == rough {
        bsdf = bsdf.with("distribution", Value::Text("ggx".into()));
    }
    Ok(entries.into_iter().fold(bsdf, |bsdf, (key, value)| bsdf.with(key, value)))
}
