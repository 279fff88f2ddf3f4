//! Coated materials, which pbrt simulates by random walks between two layers. Mitsuba's plastics and coatings are closed forms.

use super::coat_loss::Loss;
use super::maker::Maker;
use super::metals;
use super::nodes::{Node, rgb};
use super::roughness::{self, Facets};
use crate::Result;
use crate::scene::description::kinds::Kind;
use crate::scene::description::make::{nested, object, two_sided};
use crate::scene::description::object::{Object, Value};

/// Albedo for which the loss in a coat is computed where a texture gives the albedo.
const MEAN_ALBEDO: f64 = 0.5;

/// Reads a `coateddiffuse`: a dielectric layer over a diffuse base. Internal reflections are kept, and the light that the coat
/// absorbs is taken from the base.
pub(super) fn diffuse(maker: &mut Maker) -> Result<Object> {
    let entity = maker.entity;
    let facets = roughness::read(maker, "")?;
    let eta = maker.index("eta", 1.5)?;
    let alpha = roughness::uniform(maker, facets)?;
    let thickness = thickness(maker)?;
    let loss = Loss::new(eta, thickness);
    let node = maker.textures.color(&entity.parameters, entity, "reflectance", 0.5)?;
    let node = match node {
        Node::Constant(color) => Node::Constant(color.map(|albedo| loss.base(albedo.clamp(0.0, 1.0)))),
        node => maker.textures.scaled(node, loss.base(MEAN_ALBEDO) / MEAN_ALBEDO, entity)?,
    };
    let reflectance = maker.value(&node)?;
    if eta == 1.0 {
        return Ok(two_sided(object(Kind::Bsdf, "diffuse", [("reflectance", reflectance)])));
    }
    let plugin = if alpha > 0.0 { "roughplastic" } else { "plastic" };
    maker.warn(&format!("it is read as a `{plugin}`, whose layers are simulated by a formula"));
    let entries = [
        ("int_ior", Value::Float(eta)),
        ("ext_ior", Value::Float(1.0)),
        ("nonlinear", Value::Boolean(true)),
        ("diffuse_reflectance", reflectance),
    ];
    let mut plastic = object(Kind::Bsdf, plugin, entries);
    if alpha > 0.0 {
        plastic = plastic.with("alpha", Value::Float(alpha));
        plastic = plastic.with("distribution", Value::Text("ggx".into()));
    }
    Ok(two_sided(plastic))
}

/// Reads a `coatedconductor`: a dielectric layer over a conductor.
pub(super) fn conductor(maker: &mut Maker) -> Result<Object> {
    let coat = roughness::read(maker, "interface.")?;
    let facets = roughness::read(maker, "conductor.")?;
    let eta = maker.index("interface.eta", 1.5)?;
    let entries = metals::metal(maker, ["conductor.eta", "conductor.k"], eta)?;
    let thickness = thickness(maker)?;
    let metal = metals::faceted(maker, "conductor", "roughconductor", facets, entries)?;
    if eta == 1.0 {
        return Ok(two_sided(metal));
    }
    let roughness = match coat {
        Facets::Smooth => "",
        _ => "; its coat is smooth",
    };
    maker.warn(&format!("it is read as a `coating`, without reflections between the layers{roughness}"));
    let entries = [
        ("int_ior", Value::Float(eta)),
        ("ext_ior", Value::Float(1.0)),
        ("sigma_a", rgb([thickness; 3])),
        ("metal", nested(metal)),
    ];
    Ok(two_sided(object(Kind::Bsdf, "coating", entries)))
}

/// Reads the thickness of a coat, which absorbs that share of light per unit of the inverse cosine.
fn thickness(maker: &mut Maker) -> Result<f64> {
    let entity = maker.entity;
    let parameters = &entity.parameters;
    parameters.ignore(&["maxdepth", "nsamples", "g"]);
    if parameters.has("albedo") {
        maker.warn("the medium within its coat absorbs, but does not scatter");
    }
    let node = maker.textures.number(parameters, "thickness", 0.01)?;
    Ok(maker.textures.mean(&node, entity)?.clamp(0.0, 100.0))
}
