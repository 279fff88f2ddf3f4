//! Diffuse transmission, as the thin principled BSDF has it.

use glam::DVec3;

use super::maker::Maker;
use super::mappings::texture;
use super::nodes::Node;
use crate::Result;
use crate::math::srgb::luminance;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::object;
use crate::scene::description::object::{Object, Value};

/// Roughness at which Burley's diffuse reflection is nearest to Lambert's.
const ROUGHNESS: f64 = 0.5;
/// Largest difference of the channels' shares that is taken for rounding.
const EVEN: f64 = 0.01;

/// Reads a `diffusetransmission`: light is reflected or passes through, diffusely on both sides.
pub(super) fn diffuse(maker: &mut Maker) -> Result<Object> {
    let entity = maker.entity;
    let parameters = &entity.parameters;
    let scale = parameters.number("scale", 1.0)?;
    let reflected = maker.textures.color(parameters, entity, "reflectance", 0.25)?;
    let passed = maker.textures.color(parameters, entity, "transmittance", 0.25)?;
    maker.warn("it is read as a `principledthin`, whose reflection is Burley's");
    if let (Node::Constant(reflected), Node::Constant(passed)) = (&reflected, &passed) {
        let shares = (0..3).filter(|&c| reflected[c] + passed[c] > 0.0).map(|c| passed[c] / (reflected[c] + passed[c]));
        let (low, high) = shares.fold((1.0_f64, 0.0_f64), |(low, high), share| (low.min(share), high.max(share)));
        if high - low > EVEN {
            maker.warn("the same share of each color passes through");
        }
    } else {
        maker.warn("the same share of each color passes through");
    }
    let both = [reflected, passed];
    let sum = maker.textures.combined(
        &both,
        entity,
        |values| ((values[0] + values[1]) * scale).min(DVec3::ONE),
        |[reflected, passed]| {
            let sum = texture("add", [("a", reflected), ("b", passed)]);
            let scaled = texture("multiply", [("a", sum), ("b", Value::Float(scale))]);
            texture("minimum", [("a", scaled), ("b", Value::Float(1.0))])
        },
    )?;
    let share = maker.textures.combined(
        &both,
        entity,
        |values| {
            let [reflected, passed] = [values[0], values[1]].map(|color| luminance(color.to_array()));
            // Mitsuba's parameter is 2 where all light passes through.
            DVec3::splat(if reflected + passed > 0.0 { 2.0 * passed / (reflected + passed) } else { 0.0 })
        },
        |both| {
            let [reflected, passed] = both.map(|color| texture("luminance", [("value", color)]));
            let twice = texture("multiply", [("a", passed.clone()), ("b", Value::Float(2.0))]);
            texture("divide", [("a", twice), ("b", texture("add", [("a", reflected), ("b", passed)]))])
        },
    )?;
    let entries = [
        ("base_color", maker.value(&sum)?),
        ("diff_trans", maker.number(&share)?),
        ("roughness", Value::Float(ROUGHNESS)),
    ];
    Ok(object(Kind::Bsdf, "principledthin", entries))
}
