//! Coated materials, which pbrt simulates by random walks between two layers. Mitsuba's plastics and coatings are closed forms.

use super::maker::{Maker, two_sided};
use super::metals;
use super::roughness::{self, Facets};
use crate::Result;
use crate::scene::values::{object, with};
use crate::scene::{Dictionary, Value};

/// Reads a `coateddiffuse`: a dielectric layer over a diffuse base, whose internal reflections are kept.
pub(super) fn diffuse(maker: &mut Maker) -> Result<Dictionary> {
    let facets = roughness::read(maker, "")?;
    let eta = maker.index("eta", 1.5)?;
    let alpha = roughness::uniform(maker, facets)?;
    warn_of_medium(maker)?;
    let plugin = if alpha > 0.0 { "roughplastic" } else { "plastic" };
    maker.warn(&format!("it is read as `{plugin}`, which has no light lost on the way through the coat"));
    let reflectance = maker.color("reflectance", 0.5)?;
    if eta == 1.0 {
        return Ok(two_sided(object("diffuse", [("reflectance", reflectance)])));
    }
    let entries = [
        ("int_ior", Value::Number(eta)),
        ("ext_ior", Value::Number(1.0)),
        ("nonlinear", Value::Boolean(true)),
        ("diffuse_reflectance", reflectance),
    ];
    let mut plastic = object(plugin, entries);
    if alpha > 0.0 {
        plastic = with(plastic, "alpha", Value::Number(alpha));
        plastic = with(plastic, "distribution", Value::Text("ggx".into()));
    }
    Ok(two_sided(plastic))
}

/// Reads a `coatedconductor`: a dielectric layer over a conductor.
pub(super) fn conductor(maker: &mut Maker) -> Result<Dictionary> {
    let coat = roughness::read(maker, "interface.")?;
    let facets = roughness::read(maker, "conductor.")?;
    let eta = maker.index("interface.eta", 1.5)?;
    let entries = metals::metal(maker, ["conductor.eta", "conductor.k"], eta)?;
    warn_of_medium(maker)?;
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
        ("int_ior", Value::Number(eta)),
        ("ext_ior", Value::Number(1.0)),
        ("thickness", Value::Number(1.0)),
        ("metal", Value::Object(metal)),
    ];
    Ok(two_sided(object("coating", entries)))
}

/// Warns of what fills the coat.
fn warn_of_medium(maker: &mut Maker) -> Result<()> {
    let parameters = &maker.entity.parameters;
    parameters.ignore(&["maxdepth", "nsamples", "thickness", "g"]);
    if parameters.has("albedo") {
        maker.warn("the medium within its coat is not rendered");
    }
    Ok(())
}
