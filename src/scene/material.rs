//! `<bsdf>` to [`Material`].

use glam::Vec3;

use super::element::Element;
use super::properties::{Ids, Properties};
use super::{Bsdf, Material, MaterialKind, SurfaceMaterial, Textured};
use crate::Result;

const SUPPORTED: [&str; 2] = ["diffuse", "twosided"];

/// Mitsuba's albedo where none is given.
const DEFAULT_REFLECTANCE: f32 = 0.5;

/// What a shape without a BSDF is made of.
pub(super) fn default_material() -> Material {
    let bsdf = Bsdf::Diffuse { reflectance: Textured::constant(Vec3::splat(DEFAULT_REFLECTANCE)) };
    surface("default".to_string(), bsdf, false)
}

/// What a shape without a BSDF is made of where it emits.
pub(super) fn emitter_material() -> Material {
    let bsdf = Bsdf::Diffuse { reflectance: Textured::constant(Vec3::ZERO) };
    surface("default of emitters".to_string(), bsdf, false)
}

fn surface(name: String, bsdf: Bsdf, two_sided: bool) -> Material {
    let surface = SurfaceMaterial { two_sided, ..SurfaceMaterial::plain(bsdf) };
    Material { name, kind: MaterialKind::Surface(surface) }
}

/// Reads a `<bsdf>`, under the name it has in messages.
pub(super) fn parse<'a>(
    element: &'a Element,
    name: String,
    ids: &Ids<'a>,
    warnings: &mut Vec<String>,
) -> Result<Material> {
    if element.plugin()? != "twosided" {
        return Ok(surface(name, parse_bsdf(element, ids, warnings)?, false));
    }
    let mut properties = Properties::new(element, ids)?;
    let nested = properties.objects("bsdf");
    properties.finish(warnings)?;
    match nested[..] {
        [inner] if inner.attribute("type") == Some("twosided") => {
            Err(inner.error("bsdf plugin `twosided` cannot stand inside another `twosided`"))
        }
        [inner] => Ok(surface(name, parse_bsdf(inner, ids, warnings)?, true)),
        [] => Err(element.error("bsdf plugin `twosided` needs a nested <bsdf>")),
        [_, second, ..] => Err(second.error("bsdf plugin `twosided` with two different sides is not supported")),
    }
}

fn parse_bsdf<'a>(element: &'a Element, ids: &Ids<'a>, warnings: &mut Vec<String>) -> Result<Bsdf> {
    let mut properties = Properties::new(element, ids)?;
    let bsdf = match properties.plugin() {
        "diffuse" => Bsdf::Diffuse { reflectance: Textured::constant(reflectance(&mut properties, warnings)?) },
        _ => return Err(element.unsupported(&SUPPORTED)),
    };
    properties.finish(warnings)?;
    Ok(bsdf)
}

fn reflectance(properties: &mut Properties, warnings: &mut Vec<String>) -> Result<Vec3> {
    if let Some(texture) = properties.objects("texture").first() {
        return Err(texture.error("textures are not supported yet; give the `reflectance` as <rgb>"));
    }
    let location = properties.location("reflectance");
    let reflectance = properties.color("reflectance")?.unwrap_or(Vec3::splat(DEFAULT_REFLECTANCE));
    if reflectance.max_element() > 1.0 {
        warnings.push(format!("{location}: a `reflectance` above 1 would create light; clamped to 1"));
    }
    Ok(reflectance.min(Vec3::ONE))
}
