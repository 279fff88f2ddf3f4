//! Readers of the plugins that scatter by themselves.

use glam::Vec3;

use super::parameters::{DEFAULT_REFLECTANCE, Parameters};
use super::{hair, ior, lobes, principled};
use crate::Result;
use crate::scene::bsdf::{Bsdf, Distribution};
use crate::scene::texture::Textured;

/// Reader of a plugin.
type Reader = fn(&mut Parameters) -> Result<Bsdf>;

/// Plugins with their readers.
pub(super) const READERS: &[(&str, Reader)] = &[
    ("diffuse", |parameters| Ok(Bsdf::Diffuse { reflectance: albedo(parameters)? })),
    ("roughdiffuse", rough_diffuse),
    ("dielectric", |parameters| dielectric(parameters, false)),
    ("thindielectric", |parameters| dielectric(parameters, true)),
    ("roughdielectric", rough_dielectric),
    ("conductor", conductor),
    ("roughconductor", rough_conductor),
    ("roughconductorGGX", rough_conductor_ggx),
    ("plastic", plastic),
    ("roughplastic", rough_plastic),
    ("pplastic", polarized_plastic),
    ("principled", |parameters| principled::principled(parameters).map(Bsdf::Principled)),
    ("principledthin", |parameters| principled::thin(parameters).map(Bsdf::PrincipledThin)),
    ("difftrans", |parameters| principled::diffuse_transmitter(parameters).map(Bsdf::PrincipledThin)),
    ("measured", |parameters| parameters.measured.read(&mut parameters.properties)),
    ("phong", lobes::phong),
    ("ward", lobes::ward),
    ("hair", hair::hair),
];

/// Mitsuba's default materials of dielectrics and plastics.
const DEFAULT_GLASS: &str = "bk7";
const DEFAULT_PLASTIC: &str = "polypropylene";

/// Reads the parameters of a plugin in [`READERS`]; `None` for any other.
pub(super) fn parse(parameters: &mut Parameters) -> Result<Option<Bsdf>> {
    let plugin = parameters.properties.plugin();
    let reader = READERS.iter().find(|(name, _)| *name == plugin);
    reader.map(|(_, read)| read(parameters)).transpose()
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
    let fast_approximation = parameters.properties.boolean("use_fast_approx")?.unwrap_or(false);
    let energy_preserving = parameters.properties.boolean("energy_preserving")?.unwrap_or(false);
    if fast_approximation && energy_preserving {
        let message = "a `roughdiffuse` has `use_fast_approx` or `energy_preserving`, not both; leave one out";
        return Err(parameters.owner().error(message));
    }
    let alpha = match energy_preserving {
        true => parameters.share("alpha", 0.2)?,
        false => parameters.scalar("alpha", 0.2)?,
    };
    Ok(Bsdf::RoughDiffuse { reflectance: albedo(parameters)?, alpha, fast_approximation, energy_preserving })
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
        return Err(parameters.owner().error("`int_ior` and `ext_ior` of a rough dielectric must differ"));
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
    let nonlinear = parameters.properties.boolean("nonlinear")?.unwrap_or(false);
    let weighted_base = parameters.properties.has("base_weight");
    if nonlinear && weighted_base {
        let message = "a `plastic` has `nonlinear` or `base_weight`, not both; leave one out";
        return Err(parameters.owner().error(message));
    }
    let (rough_base, base_roughness) = base_roughness(parameters)?;
    Ok(Bsdf::Plastic {
        eta: ior::relative(&mut parameters.properties, DEFAULT_PLASTIC)?,
        diffuse_reflectance: parameters.reflectance("diffuse_reflectance", DEFAULT_REFLECTANCE)?,
        specular_reflectance: parameters.reflectance("specular_reflectance", 1.0)?,
        nonlinear,
        weighted_base,
        base_weight: parameters.share("base_weight", 1.0)?,
        rough_base,
        base_roughness,
    })
}

/// Reads whether a weighted base is rough, and its roughness.
fn base_roughness(parameters: &mut Parameters) -> Result<(bool, Textured<f32>)> {
    let location = parameters.properties.location("base_roughness");
    let is_given = parameters.properties.has("base_roughness");
    if is_given && !parameters.properties.has("base_weight") {
        return Err(location.error("`base_roughness` needs `base_weight`; give both, or leave both out"));
    }
    let roughness = parameters.share("base_roughness", 0.0)?;
    Ok((is_given && roughness != Textured::constant(0.0), roughness))
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

/// Reads a `pplastic`. What it adds for polarized light has no counterpart here.
fn polarized_plastic(parameters: &mut Parameters) -> Result<Bsdf> {
    let eta = ior::relative(&mut parameters.properties, DEFAULT_PLASTIC)?;
    if eta == 1.0 {
        return Err(parameters.owner().error("`int_ior` and `ext_ior` of a `pplastic` must differ"));
    }
    let (rough_base, base_roughness) = base_roughness(parameters)?;
    Ok(Bsdf::PolarizedPlastic {
        microfacets: parameters.microfacets()?,
        eta,
        diffuse_reflectance: parameters.reflectance("diffuse_reflectance", DEFAULT_REFLECTANCE)?,
        specular_reflectance: parameters.reflectance("specular_reflectance", 1.0)?,
        weighted_base: parameters.properties.has("base_weight"),
        base_weight: parameters.share("base_weight", 1.0)?,
        rough_base,
        base_roughness,
    })
}
