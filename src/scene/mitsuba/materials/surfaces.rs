//! Readers of the plugins that scatter by themselves.

use glam::Vec3;

use super::ior;
use super::parameters::Parameters;
use crate::Result;
use crate::scene::bsdf::{Bsdf, Distribution, Principled};
use crate::scene::texture::Textured;

/// Plugins that [`parse`] reads.
pub(super) const SUPPORTED: [&str; 11] = [
    "diffuse",
    "roughdiffuse",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "conductor",
    "roughconductor",
    "roughconductorGGX",
    "plastic",
    "roughplastic",
    "principled",
];

/// Mitsuba's default albedo.
pub(super) const DEFAULT_REFLECTANCE: f32 = 0.5;

/// Mitsuba's default materials of dielectrics and plastics.
const DEFAULT_GLASS: &str = "bk7";
const DEFAULT_PLASTIC: &str = "polypropylene";

/// Reads the parameters of a plugin in [`SUPPORTED`]; `None` for any other.
pub(super) fn parse(parameters: &mut Parameters) -> Result<Option<Bsdf>> {
    let bsdf = match parameters.properties.plugin() {
        "diffuse" => Bsdf::Diffuse { reflectance: albedo(parameters)? },
        "roughdiffuse" => rough_diffuse(parameters)?,
        "dielectric" => dielectric(parameters, false)?,
        "thindielectric" => dielectric(parameters, true)?,
        "roughdielectric" => rough_dielectric(parameters)?,
        "conductor" => conductor(parameters)?,
        "roughconductor" => rough_conductor(parameters)?,
        "roughconductorGGX" => rough_conductor_ggx(parameters)?,
        "plastic" => plastic(parameters)?,
        "roughplastic" => rough_plastic(parameters)?,
        "principled" => Bsdf::Principled(principled(parameters)?),
        _ => return Ok(None),
    };
    Ok(Some(bsdf))
}

/// Reads the albedo of a diffuse surface. Mitsuba 0.6 knows it as `diffuseReflectance`, too.
fn albedo(parameters: &mut Parameters) -> Result<Textured<Vec3>> {
    let name = match parameters.properties.has("reflectance") {
        true => "reflectance",
        false => "diffuse_reflectance",
    };
    parameters.reflectance(name, DEFAULT_REFLECTANCE)
}

/// Reads a `roughdiffuse`, a plugin of Mitsuba 0.6 that Mitsuba 3 lacks.
fn rough_diffuse(parameters: &mut Parameters) -> Result<Bsdf> {
    Ok(Bsdf::RoughDiffuse {
        reflectance: albedo(parameters)?,
        alpha: parameters.scalar("alpha", 0.2)?,
        fast_approximation: parameters.properties.boolean("use_fast_approx")?.unwrap_or(false),
    })
}

fn dielectric(parameters: &mut Parameters, thin: bool) -> Result<Bsdf> {
    let eta = ior::relative(&mut parameters.properties, DEFAULT_GLASS)?;
    let specular_reflectance = parameters.reflectance("specular_reflectance", 1.0)?;
    let specular_transmittance = parameters.reflectance("specular_transmittance", 1.0)?;
    Ok(match thin {
        true => Bsdf::ThinDielectric { eta, specular_reflectance, specular_transmittance },
        false => Bsdf::Dielectric { eta, specular_reflectance, specular_transmittance },
    })
}

fn rough_dielectric(parameters: &mut Parameters) -> Result<Bsdf> {
    let eta = ior::relative(&mut parameters.properties, DEFAULT_GLASS)?;
    if eta == 1.0 {
        return Err(parameters.element().error("`int_ior` and `ext_ior` of a rough dielectric must differ"));
    }
    Ok(Bsdf::RoughDielectric {
        microfacets: parameters.microfacets()?,
        eta,
        specular_reflectance: parameters.reflectance("specular_reflectance", 1.0)?,
        specular_transmittance: parameters.reflectance("specular_transmittance", 1.0)?,
    })
}

fn conductor(parameters: &mut Parameters) -> Result<Bsdf> {
    let (eta, k) = parameters.conductor()?;
    Ok(Bsdf::Conductor { eta, k, specular_reflectance: parameters.reflectance("specular_reflectance", 1.0)? })
}

fn rough_conductor(parameters: &mut Parameters) -> Result<Bsdf> {
    let (eta, k) = parameters.conductor()?;
    Ok(Bsdf::RoughConductor {
        microfacets: parameters.microfacets()?,
        eta,
        k,
        specular_reflectance: parameters.reflectance("specular_reflectance", 1.0)?,
    })
}

/// Reads a `roughconductorGGX`, an old name of a `roughconductor` whose distribution is `ggx`.
fn rough_conductor_ggx(parameters: &mut Parameters) -> Result<Bsdf> {
    let location = parameters.properties.location("distribution");
    if parameters.properties.take("distribution").is_some() {
        return Err(location.error("the distribution of a `roughconductorGGX` is `ggx`; leave `distribution` out"));
    }
    let mut bsdf = rough_conductor(parameters)?;
    if let Bsdf::RoughConductor { microfacets, .. } = &mut bsdf {
        microfacets.distribution = Distribution::Ggx;
    }
    Ok(bsdf)
}

fn plastic(parameters: &mut Parameters) -> Result<Bsdf> {
    // Sampling rates of lobes change the noise only.
    parameters.properties.ignore_sampling(&["specular_sampling_weight"]);
    Ok(Bsdf::Plastic {
        eta: ior::relative(&mut parameters.properties, DEFAULT_PLASTIC)?,
        diffuse_reflectance: parameters.reflectance("diffuse_reflectance", DEFAULT_REFLECTANCE)?,
        specular_reflectance: parameters.reflectance("specular_reflectance", 1.0)?,
        nonlinear: parameters.properties.boolean("nonlinear")?.unwrap_or(false),
    })
}

fn rough_plastic(parameters: &mut Parameters) -> Result<Bsdf> {
    parameters.properties.ignore_sampling(&["specular_sampling_weight"]);
    let (distribution, alpha) = parameters.uniform_microfacets()?;
    Ok(Bsdf::RoughPlastic {
        distribution,
        alpha,
        eta: ior::relative(&mut parameters.properties, DEFAULT_PLASTIC)?,
        diffuse_reflectance: parameters.reflectance("diffuse_reflectance", DEFAULT_REFLECTANCE)?,
        specular_reflectance: parameters.reflectance("specular_reflectance", 1.0)?,
        nonlinear: parameters.properties.boolean("nonlinear")?.unwrap_or(false),
    })
}

fn principled(parameters: &mut Parameters) -> Result<Principled> {
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
