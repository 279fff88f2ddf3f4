//! Reader of a thin film, which Mitsuba does not have.

use super::parameters::Parameters;
use crate::Result;
use crate::scene::bsdf::{Bsdf, Film};
use crate::scene::texture::Textured;

/// Index of refraction of a film without one, as in glTF.
const DEFAULT_ETA: f32 = 1.3;

/// Reads `film_thickness` and `film_eta` of a BSDF that may have a film. Without a thickness there is none.
pub(super) fn film(parameters: &mut Parameters, bsdf: &Bsdf) -> Result<Option<Film>> {
    let is_base = match bsdf {
        Bsdf::Principled(_)
        | Bsdf::Dielectric { .. }
        | Bsdf::RoughDielectric { .. }
        | Bsdf::Conductor { .. }
        | Bsdf::RoughConductor { .. } => true,
        Bsdf::Plastic { weighted_base, .. } | Bsdf::PolarizedPlastic { weighted_base, .. } => *weighted_base,
        _ => false,
    };
    if !is_base {
        return refuse(parameters, bsdf);
    }
    let properties = &mut parameters.properties;
    if !properties.has("film_thickness") {
        return match properties.has("film_eta") {
            true => {
                Err(properties.location("film_eta").error("`film_eta` needs `film_thickness`; give both, or neither"))
            }
            false => Ok(None),
        };
    }
    let location = properties.location("film_thickness");
    let eta = properties.positive_float("film_eta", DEFAULT_ETA)?;
    let thickness = parameters.scalar("film_thickness", 0.0)?;
    if thickness.value < 0.0 {
        return Err(location.error(format!("`film_thickness` must not be negative, as {} is", thickness.value)));
    }
    Ok((thickness != Textured::constant(0.0)).then_some(Film { thickness, eta }))
}

/// Refuses a film over a plastic whose base has no weight. Other BSDFs report the parameters as unknown.
fn refuse(parameters: &Parameters, bsdf: &Bsdf) -> Result<Option<Film>> {
    match bsdf {
        Bsdf::Plastic { .. } | Bsdf::PolarizedPlastic { .. } if parameters.properties.has("film_thickness") => {
            let message = "a film over a plastic needs `base_weight`; give it, or leave `film_thickness` out";
            Err(parameters.properties.location("film_thickness").error(message))
        }
        _ => Ok(None),
    }
}
