//! Colors, as linear sRGB.

use glam::Vec3;

use super::element::Element;
use super::numbers;
use crate::Result;

/// The color that a `<rgb>`, `<srgb>`, `<spectrum>` or `<float>` names.
pub(super) fn parse(element: &Element) -> Result<Vec3> {
    let value = match element.tag.as_str() {
        "spectrum" => check_spectrum(element)?,
        "blackbody" => return Err(element.error("<blackbody> is not supported; give the color as <rgb>")),
        _ => element.required("value")?,
    };
    let color = match (element.tag.as_str(), value.trim().strip_prefix('#')) {
        ("srgb", Some(digits)) => parse_hex(element, digits)?,
        (tag, Some(_)) => return Err(element.error(format!("`{value}` in <{tag}>: hex digits need <srgb>"))),
        _ => numbers::one_or_three(element, value)?,
    };
    let color = if element.tag == "srgb" { color.map(linear_from_srgb) } else { color };
    if color.iter().any(|&channel| channel < 0.0) {
        return Err(element.error(format!("the color `{value}` is negative")));
    }
    Ok(Vec3::from_array(color.map(|channel| channel as f32)))
}

fn check_spectrum(element: &Element) -> Result<&str> {
    match element.attribute("value") {
        Some(value) if !value.contains(':') => Ok(value),
        _ => Err(element.error("spectra over wavelengths are not supported; give the color as <rgb>")),
    }
}

fn parse_hex(element: &Element, digits: &str) -> Result<[f64; 3]> {
    let malformed = || element.error(format!("`#{digits}` should be # and six hexadecimal digits"));
    let bits = u32::from_str_radix(digits, 16).map_err(|_| malformed())?;
    if digits.len() != 6 {
        return Err(malformed());
    }
    Ok([bits >> 16, bits >> 8 & 255, bits & 255].map(|channel| f64::from(channel) / 255.0))
}

fn linear_from_srgb(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
