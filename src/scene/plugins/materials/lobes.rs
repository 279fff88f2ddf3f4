//! Readers of `phong` and `ward`, plugins of Mitsuba 0.6 that Mitsuba 3 lacks, and their conservation of energy.

use glam::Vec3;

use super::parameters::{DEFAULT_REFLECTANCE, Parameters};
use crate::Result;
use crate::scene::bsdf::{Bsdf, Material, MaterialKind, WardVariant};
use crate::scene::texture::{Image, Texture, Textured};

/// Mitsuba's default factor of the highlight.
const DEFAULT_SPECULAR: f32 = 0.2;
/// Mitsuba's default exponent of `phong`.
const DEFAULT_EXPONENT: f32 = 30.0;

/// Reads a `phong`.
pub(super) fn phong(parameters: &mut Parameters) -> Result<Bsdf> {
    warn_of_energy(parameters)?;
    let location = parameters.properties.location("exponent");
    let exponent = parameters.scalar("exponent", DEFAULT_EXPONENT)?;
    if exponent.texture.is_none() && exponent.value < 0.0 {
        return Err(location.error(format!("`exponent` must not be negative, as {} is", exponent.value)));
    }
    Ok(Bsdf::Phong {
        exponent,
        diffuse_reflectance: parameters.reflectance("diffuse_reflectance", DEFAULT_REFLECTANCE)?,
        specular_reflectance: parameters.reflectance("specular_reflectance", DEFAULT_SPECULAR)?,
    })
}

/// Reads a `ward`.
pub(super) fn ward(parameters: &mut Parameters) -> Result<Bsdf> {
    warn_of_energy(parameters)?;
    let location = parameters.properties.location("variant");
    let variant = match parameters.properties.string("variant")?.map(str::to_ascii_lowercase).as_deref() {
        None | Some("balanced") => WardVariant::Balanced,
        Some("ward") => WardVariant::Ward,
        Some("ward-duer") => WardVariant::Duer,
        Some(other) => {
            let message = format!("the variant `{other}` is not known; use `balanced`, `ward` or `ward-duer`");
            return Err(location.error(message));
        }
    };
    let both = parameters.alpha("alpha")?;
    let mut alpha = |name: &str| match parameters.properties.has(name) {
        true => parameters.alpha(name),
        false => Ok(both),
    };
    Ok(Bsdf::Ward {
        variant,
        alpha_u: alpha("alpha_u")?,
        alpha_v: alpha("alpha_v")?,
        diffuse_reflectance: parameters.reflectance("diffuse_reflectance", DEFAULT_REFLECTANCE)?,
        specular_reflectance: parameters.reflectance("specular_reflectance", DEFAULT_SPECULAR)?,
    })
}

fn warn_of_energy(parameters: &mut Parameters) -> Result<()> {
    let location = parameters.properties.location("ensure_energy_conservation");
    if parameters.properties.boolean("ensure_energy_conservation")? == Some(false) {
        let message = "`ensureEnergyConservation` cannot be switched off; reflectances above 1 are scaled";
        parameters.warnings.push(format!("{location}: {message}"));
    }
    Ok(())
}

/// Scales the two reflectances of every `phong` and `ward` whose sum exceeds 1, as Mitsuba 0.6 does.
pub(in super::super) fn conserve_energy(
    materials: &mut [Material],
    textures: &[Texture],
    images: &[Image],
    warnings: &mut Vec<String>,
) {
    let largest = |textured: &Textured<Vec3>| {
        textured.value * textured.texture.map_or(Vec3::ONE, |texture| textures[texture as usize].maximum(images))
    };
    for Material { name, kind, .. } in materials {
        let MaterialKind::Surface(surface) = kind else { continue };
        let (Bsdf::Phong { diffuse_reflectance, specular_reflectance, .. }
        | Bsdf::Ward { diffuse_reflectance, specular_reflectance, .. }) = &mut surface.bsdf
        else {
            continue;
        };
        let sum = (largest(diffuse_reflectance) + largest(specular_reflectance)).max_element();
        if sum > 1.0 {
            let scale = 0.99 / sum;
            diffuse_reflectance.value *= scale;
            specular_reflectance.value *= scale;
            warnings.push(format!("the reflectances of `{name}` sum to {sum}; both are scaled by {scale:.3}"));
        }
    }
}
