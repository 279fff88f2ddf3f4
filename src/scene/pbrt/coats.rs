//! Coated materials, which pbrt simulates by random walks between two layers. Mitsuba's plastics and coatings are closed forms.

use super::maker::{Maker, two_sided};
use super::metals;
use super::nodes::{Node, rgb};
use super::roughness::{self, Facets};
use crate::Result;
use crate::math::fresnel::fresnel_dielectric;
use crate::scene::values::{object, with};
use crate::scene::{Dictionary, Value};

/// Number of angles over which the light within a coat is summed.
const ANGLES: usize = 512;
/// Cosine within a coat of light that comes from outside, about the mean over all directions.
const MEAN_COSINE: f64 = 0.88;
/// Albedo for which the loss in a coat is computed where a texture gives the albedo.
const MEAN_ALBEDO: f64 = 0.5;

/// Reads a `coateddiffuse`: a dielectric layer over a diffuse base. Internal reflections are kept, and the light that the coat
/// absorbs is taken from the base.
pub(super) fn diffuse(maker: &mut Maker) -> Result<Dictionary> {
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
        return Ok(two_sided(object("diffuse", [("reflectance", reflectance)])));
    }
    let plugin = if alpha > 0.0 { "roughplastic" } else { "plastic" };
    maker.warn(&format!("it is read as a `{plugin}`, whose layers are simulated by a formula"));
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
        ("int_ior", Value::Number(eta)),
        ("ext_ior", Value::Number(1.0)),
        ("sigma_a", rgb([thickness; 3])),
        ("metal", Value::Object(metal)),
    ];
    Ok(two_sided(object("coating", entries)))
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

/// Light that is lost on its ways through a coat.
struct Loss {
    /// Share of the base's light that the coat's surface reflects back, without loss.
    reflected: f64,
    /// Share of the base's light that leaves the coat.
    leaving: f64,
    /// Share of the base's light that comes back to the base.
    returning: f64,
    /// Share of the light from outside that comes to the base.
    entering: f64,
}

impl Loss {
    fn new(eta: f64, thickness: f64) -> Self {
        let mut loss =
            Self { reflected: 0.0, leaving: 0.0, returning: 0.0, entering: (-thickness / MEAN_COSINE).exp() };
        for angle in 0..ANGLES {
            let cosine = (angle as f64 + 0.5) / ANGLES as f64;
            // Light from within meets the interface from its back.
            let reflected = fresnel_dielectric(-cosine, eta).reflectance;
            let (weight, kept) = (2.0 * cosine / ANGLES as f64, (-thickness / cosine).exp());
            loss.reflected += weight * reflected;
            loss.leaving += weight * (1.0 - reflected) * kept;
            loss.returning += weight * reflected * kept * kept;
        }
        loss
    }

    /// Albedo of the base under a coat without loss that reflects what the base of this albedo reflects under the coat.
    fn base(&self, albedo: f64) -> f64 {
        let out = self.entering * albedo * self.leaving / (1.0 - albedo * self.returning);
        out / ((1.0 - self.reflected) + out * self.reflected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that is followed bounce by bounce through a coat, as pbrt follows it at random.
    fn followed(albedo: f64, eta: f64, thickness: f64, base: f64, is_lossless: bool) -> f64 {
        let kept = |cosine: f64| if is_lossless { 1.0 } else { (-thickness / cosine).exp() };
        let mut light = if is_lossless { base } else { albedo * kept(MEAN_COSINE) };
        let mut sum = 0.0;
        for _ in 0..200 {
            let mut back = 0.0;
            for angle in 0..2000 {
                let cosine = (f64::from(angle) + 0.5) / 2000.0;
                let reflected = fresnel_dielectric(-cosine, eta).reflectance;
                let weight = light * 2.0 * cosine / 2000.0;
                sum += weight * (1.0 - reflected) * kept(cosine);
                back += weight * reflected * kept(cosine).powi(2);
            }
            light = back * if is_lossless { base } else { albedo };
        }
        sum
    }

    #[test]
    fn a_coat_without_loss_reflects_as_much() {
        for (albedo, eta, thickness) in [(0.1, 1.5, 0.01), (0.5, 1.5, 0.01), (0.95, 1.3, 0.1), (0.5, 1.5, 0.0)] {
            let base = Loss::new(eta, thickness).base(albedo);
            let (with_loss, without) =
                (followed(albedo, eta, thickness, base, false), followed(albedo, eta, thickness, base, true));
            assert!((with_loss - without).abs() < 2e-3 * with_loss, "{albedo}: {with_loss} is not {without}");
            assert!(base <= albedo && (thickness > 0.0 || (base - albedo).abs() < 1e-9));
        }
    }
}
