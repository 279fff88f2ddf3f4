//! Indices of refraction, as numbers or by name.

use super::super::properties::Properties;
use crate::Result;

/// Mitsuba's table of dielectrics.
const DIELECTRICS: [(&str, f32); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// Relative index `int_ior` over `ext_ior`. Mitsuba's default for the exterior is air.
pub(super) fn relative(properties: &mut Properties, interior: &str) -> Result<f32> {
    let interior = index(properties, "int_ior", interior)?;
    let exterior = index(properties, "ext_ior", "air")?;
    Ok(interior / exterior)
}

/// Index of the exterior of a conductor: Mitsuba 0.6's `ext_eta`. Without it, vacuum as in Mitsuba 3.
pub(super) fn exterior(properties: &mut Properties) -> Result<f32> {
    index(properties, "ext_eta", "vacuum")
}

fn index(properties: &mut Properties, parameter: &str, default: &str) -> Result<f32> {
    let place = properties.location(parameter);
    if !properties.is_string(parameter) {
        let default = find(default).unwrap_or(1.0);
        return properties.positive_float(parameter, default);
    }
    let name = properties.string(parameter)?.unwrap_or(default);
    find(name).ok_or_else(|| {
        let known = DIELECTRICS.map(|(known, _)| format!("`{known}`")).join(", ");
        place.error(format!(
            "`{parameter}`: no index of refraction is known for `{name}`; use a number or one of {known}"
        ))
    })
}

fn find(name: &str) -> Option<f32> {
    DIELECTRICS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|&(_, ior)| ior)
}
