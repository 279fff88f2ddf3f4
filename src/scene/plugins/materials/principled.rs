//! Readers of `principled` and `principledthin`, and of `difftrans`, which is a special case of the latter.

use super::ior;
use super::parameters::{DEFAULT_REFLECTANCE, Parameters};
use crate::Result;
use crate::scene::bsdf::{Principled, PrincipledThin};
use crate::scene::texture::Textured;

/// Reads a `principled`.
pub(super) fn principled(parameters: &mut Parameters) -> Result<Principled> {
    // Sampling rates of lobes change the noise only.
    let rates = ["main_specular_sampling_rate", "clearcoat_sampling_rate", "diffuse_reflectance_sampling_rate"];
    parameters.properties.ignore_sampling(&rates);
    let base_color = parameters.reflectance("base_color", DEFAULT_REFLECTANCE)?;
    let roughness = parameters.share("roughness", 0.5)?;
    let spec_trans = parameters.share("spec_trans", 0.0)?;
    let transmits = spec_trans.texture.is_some() || spec_trans.value > 0.0;
    let eta = principled_eta(parameters, transmits)?;
    let mut share = |name: &str| parameters.share(name, 0.0);
    Ok(Principled {
        base_color,
        roughness,
        anisotropic: share("anisotropic")?,
        metallic: share("metallic")?,
        spec_trans,
        eta,
        spec_tint: share("spec_tint")?,
        sheen: share("sheen")?,
        sheen_tint: share("sheen_tint")?,
        flatness: share("flatness")?,
        clearcoat: share("clearcoat")?,
        clearcoat_gloss: share("clearcoat_gloss")?,
    })
}

/// Index of refraction from `eta`, or from `specular`, which is the reflectance at normal incidence divided by 0.08
/// (Burley 2012). A material that transmits needs an index other than 1; Mitsuba shifts it a little.
fn principled_eta(parameters: &mut Parameters, transmits: bool) -> Result<f32> {
    let properties = &mut parameters.properties;
    if properties.has("eta") && properties.has("specular") {
        return Err(properties.location("eta").error("give either `eta` or `specular`, not both"));
    }
    if properties.has("eta") {
        let eta = properties.positive_float("eta", 1.5)?;
        return Ok(if transmits && eta == 1.0 { 1.001 } else { eta });
    }
    let location = properties.location("specular");
    let specular = properties.float("specular")?.unwrap_or(0.5);
    if !(0.0..=1.0).contains(&specular) {
        return Err(location.error(format!("`specular` must lie in 0..1, not {specular}")));
    }
    let specular = if transmits && specular == 0.0 { 1e-3 } else { specular };
    Ok(2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0)
}

/// Reads a `principledthin`.
pub(super) fn thin(parameters: &mut Parameters) -> Result<PrincipledThin> {
    // Sampling rates of lobes change the noise only.
    let kinds = ["specular_reflectance", "specular_transmittance", "diffuse_reflectance", "diffuse_transmittance"];
    let rates = kinds.map(|kind| format!("{kind}_sampling_rate"));
    parameters.properties.ignore_sampling(&rates.each_ref().map(String::as_str));
    let base_color = parameters.reflectance("base_color", DEFAULT_REFLECTANCE)?;
    let roughness = parameters.share("roughness", 0.5)?;
    let eta = parameters.properties.positive_float("eta", 1.5)?;
    let crossing = crossing(parameters)?;
    let mut share = |name: &str| parameters.share(name, 0.0);
    Ok(PrincipledThin {
        base_color,
        roughness,
        anisotropic: share("anisotropic")?,
        spec_trans: share("spec_trans")?,
        eta,
        spec_tint: share("spec_tint")?,
        sheen: share("sheen")?,
        sheen_tint: share("sheen_tint")?,
        flatness: share("flatness")?,
        crossing,
    })
}

/// Reads a `difftrans`, a plugin of Mitsuba 0.6 that Mitsuba 3 lacks: all light that is not absorbed passes diffusely. `int_ior`, which 0.6 does
/// not have, is the index of refraction of a body from within which the surface is met, over `ext_ior`: radiance is its square times as high
/// there. So the back of a body whose front is a dielectric keeps the energy.
pub(super) fn diffuse_transmitter(parameters: &mut Parameters) -> Result<PrincipledThin> {
    let mut base_color = parameters.reflectance("transmittance", DEFAULT_REFLECTANCE)?;
    if parameters.properties.has("int_ior") {
        let eta = ior::relative(&mut parameters.properties, "bk7")?;
        base_color.value *= eta * eta;
    }
    let [none, all] = [0.0, 1.0].map(Textured::constant);
    Ok(PrincipledThin {
        base_color,
        roughness: all,
        anisotropic: none,
        spec_trans: none,
        eta: 1.5,
        spec_tint: none,
        sheen: none,
        sheen_tint: none,
        flatness: none,
        crossing: all,
    })
}

/// Reads `diff_trans`, which lies in [0, 2], and halves it.
fn crossing(parameters: &mut Parameters) -> Result<Textured<f32>> {
    let location = parameters.properties.location("diff_trans");
    let Textured { value, texture } = parameters.scalar("diff_trans", 0.0)?;
    if texture.is_none() && !(0.0..=2.0).contains(&value) {
        parameters.warnings.push(format!("{location}: `diff_trans` must lie in 0..2, not {value}; clamped"));
    }
    let value = if texture.is_none() { value.clamp(0.0, 2.0) } else { value };
    Ok(Textured { value: 0.5 * value, texture })
}
