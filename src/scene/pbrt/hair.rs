//! `hair`: Mitsuba's `hair` on curves, whose fibers run along `u`.

use glam::DVec3;

use super::maker::Maker;
use super::mappings::texture;
use super::nodes::{Node, rgb};
use crate::Result;
use crate::scene::bsdf::{EUMELANIN, PHEOMELANIN};
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::object;
use crate::scene::description::object::{Object, Value};

/// Concentration of eumelanin where a file gives no color.
const DEFAULT_EUMELANIN: f64 = 1.3;
/// Least reflectance, so that the absorption is finite.
const LEAST_REFLECTANCE: f64 = 1.0e-6;
/// Parameters that give the color, the first given one before the others.
const COLORS: [&str; 5] = ["sigma_a", "reflectance", "color", "eumelanin", "pheomelanin"];

/// Reads a `hair`.
pub(super) fn read(maker: &mut Maker) -> Result<Object> {
    let entity = maker.entity;
    let parameters = &entity.parameters;
    let eta = maker.index("eta", 1.55)?;
    if eta == 1.0 {
        return Err(entity.error("`eta` of a `hair` must not be 1; give another index of refraction"));
    }
    let [along, around] = ["beta_m", "beta_n"].map(|name| maker.textures.number(parameters, name, 0.3));
    let (along, around) = (along?, around?);
    let sigma_a = absorption(maker, &around)?;
    let entries = [
        ("sigma_a", maker.value(&sigma_a)?),
        ("longitudinal_roughness", maker.number(&along)?),
        ("azimuthal_roughness", maker.number(&around)?),
        ("scale_tilt", Value::Float(parameters.number("alpha", 2.0)?)),
        ("int_ior", Value::Float(eta)),
        ("ext_ior", Value::Float(1.0)),
        ("along_u", Value::Boolean(true)),
    ];
    Ok(object(Kind::Bsdf, "hair", entries))
}

/// Absorption per radius of the fiber.
fn absorption(maker: &mut Maker, around: &Node) -> Result<Node> {
    let entity = maker.entity;
    let parameters = &entity.parameters;
    let mut given = COLORS.iter().filter(|name| parameters.has(name));
    let Some(first) = given.next() else {
        return Ok(Node::Constant((DEFAULT_EUMELANIN * EUMELANIN).to_array()));
    };
    let is_pigment = |name: &str| name.ends_with("melanin");
    let others: Vec<&str> = given.copied().filter(|name| !(is_pigment(first) && is_pigment(name))).collect();
    if !others.is_empty() {
        maker.warn(&format!("`{}` is ignored beside `{first}`, as in pbrt", others.join("` and `")));
        parameters.ignore(&others);
    }
    if is_pigment(first) {
        let [eumelanin, pheomelanin] =
            ["eumelanin", "pheomelanin"].map(|name| maker.textures.number(parameters, name, 0.0));
        return maker.textures.combined(
            &[eumelanin?, pheomelanin?],
            entity,
            |values| values[0].x.max(0.0) * EUMELANIN + values[1].x.max(0.0) * PHEOMELANIN,
            |[eumelanin, pheomelanin]| {
                let [first, second] = [(eumelanin, EUMELANIN), (pheomelanin, PHEOMELANIN)]
                    .map(|(share, color)| texture("multiply", [("a", share), ("b", rgb(color.to_array()))]));
                texture("add", [("a", first), ("b", second)])
            },
        );
    }
    let color = maker.textures.color(parameters, entity, first, 0.0)?;
    if *first == "sigma_a" {
        return Ok(color);
    }
    if !matches!(around, Node::Constant(_)) {
        maker.warn(&format!("`{first}` becomes an absorption by the mean of `beta_n`"));
    }
    let depth = optical_depth(maker.textures.mean(around, entity)?);
    let by_channel = move |color: f64| (color.clamp(LEAST_REFLECTANCE, 1.0).ln() / depth).powi(2);
    maker.textures.combined(
        &[color],
        entity,
        |values| DVec3::from_array(values[0].to_array().map(by_channel)),
        |[color]| {
            let within = texture("maximum", [("a", color), ("b", Value::Float(LEAST_REFLECTANCE))]);
            let within = texture("minimum", [("a", within), ("b", Value::Float(1.0))]);
            let logarithm = texture("logarithm", [("value", within)]);
            let root = texture("multiply", [("a", logarithm), ("b", Value::Float(1.0 / depth))]);
            texture("power", [("a", root), ("b", Value::Float(2.0))])
        },
    )
}

/// Divisor of the fit that gives the absorption of many fibers of a color (Chiang et al. 2016, equation 9), by the roughness around them.
fn optical_depth(roughness: f64) -> f64 {
    let n = roughness;
    5.969 + n * (-0.215 + n * (2.532 + n * (-10.73 + n * (5.574 + n * 0.245))))
}
