//! Reader of `hair`, the fiber of Chiang et al. (2016).

use glam::Vec3;

use super::super::emission::non_negative;
use super::ior;
use super::parameters::Parameters;
use crate::Result;
use crate::scene::bsdf::{Bsdf, EUMELANIN, PHEOMELANIN};
use crate::scene::texture::Textured;

/// Mitsuba's default index of refraction, roughness, and angle of the scales in degrees.
const DEFAULT_FIBER: &str = "amber";
const DEFAULT_ROUGHNESS: f32 = 0.3;
const DEFAULT_TILT: f32 = 2.0;

/// Reads a `hair`.
pub(super) fn hair(parameters: &mut Parameters) -> Result<Bsdf> {
    let eta = ior::relative(&mut parameters.properties, DEFAULT_FIBER)?;
    if eta == 1.0 {
        return Err(parameters.owner().error("`int_ior` and `ext_ior` of a `hair` must differ"));
    }
    let tilt = parameters.properties.float("scale_tilt")?.unwrap_or(DEFAULT_TILT);
    Ok(Bsdf::Hair {
        sigma_a: absorption(parameters)?,
        longitudinal_roughness: parameters.share("longitudinal_roughness", DEFAULT_ROUGHNESS)?,
        azimuthal_roughness: parameters.share("azimuthal_roughness", DEFAULT_ROUGHNESS)?,
        eta,
        tilt_sine: tilt.to_radians().sin(),
        along_u: parameters.properties.boolean("along_u")?.unwrap_or(false),
    })
}

/// Reads the absorption: `sigma_a` times `scale`, or that of pigments.
fn absorption(parameters: &mut Parameters) -> Result<Textured<Vec3>> {
    let has_pigments = ["eumelanin", "pheomelanin"].iter().any(|name| parameters.properties.has(name));
    let scale = non_negative(&mut parameters.properties, "scale", 1.0)?;
    match parameters.absorption("sigma_a")? {
        Some(_) if has_pigments => {
            let message = "a `hair` has `sigma_a`, or `eumelanin` and `pheomelanin`; leave out one or the others";
            Err(parameters.owner().error(message))
        }
        Some(sigma_a) => Ok(Textured { value: scale * sigma_a.value, ..sigma_a }),
        None => {
            let eumelanin = non_negative(&mut parameters.properties, "eumelanin", 1.3)?;
            let pheomelanin = non_negative(&mut parameters.properties, "pheomelanin", 0.2)?;
            Ok(Textured::constant(eumelanin * EUMELANIN.as_vec3() + pheomelanin * PHEOMELANIN.as_vec3()))
        }
    }
}
