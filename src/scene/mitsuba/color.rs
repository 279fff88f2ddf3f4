//! Colors as linear sRGB.

use glam::Vec3;

use super::element::Element;
use super::folders::Folders;
use super::spectrum::SpectrumUse;
use super::{numbers, spectrum};
use crate::Result;
use crate::math::srgb::linear_from_srgb;

/// Color of a `<rgb>`, `<srgb>`, `<spectrum>` or `<float>`. Negative channels are an error.
pub(super) fn parse(element: &Element, spectrum_use: SpectrumUse, folders: &Folders) -> Result<Vec3> {
    let color = parse_signed(element, spectrum_use, folders)?;
    match color.to_array().iter().find(|&&channel| channel < 0.0) {
        Some(channel) => Err(element.error(format!("a color must not be negative, as {channel} is"))),
        None => Ok(color),
    }
}

/// Color whose channels may be negative, such as an index of refraction that a fit has left negative in one channel.
pub(super) fn parse_signed(element: &Element, spectrum_use: SpectrumUse, folders: &Folders) -> Result<Vec3> {
    let color = match element.tag.as_str() {
        "blackbody" => return Err(element.error("<blackbody> is not supported; give the color as <rgb>")),
        "spectrum" => parse_spectrum(element, spectrum_use, folders)?,
        "srgb" => parse_srgb(element)?.map(linear_from_srgb),
        _ => parse_linear(element)?,
    };
    Ok(Vec3::from_array(color.map(|channel| channel as f32)))
}

fn parse_spectrum(element: &Element, spectrum_use: SpectrumUse, folders: &Folders) -> Result<[f64; 3]> {
    if let Some(plugin) = element.attribute("type") {
        return parse_spectrum_plugin(element, plugin);
    }
    match element.attribute("value") {
        Some(value) if !value.contains(':') => match numbers::list(element, value)?[..] {
            [value] => Ok(spectrum::uniform(value, spectrum_use)),
            // Mitsuba 0.6 accepts three numbers as a color.
            [red, green, blue] => Ok([red, green, blue]),
            _ => Err(element.error(format!("`{value}` should be one number, three, or wavelength:value pairs"))),
        },
        _ => spectrum::parse(element, spectrum_use, folders),
    }
}

/// Color of a spectrum that is given as a plugin of Mitsuba 3. All of these are exact in its rgb variants, where `uniform`
/// and `d65` are white also as emitted light.
fn parse_spectrum_plugin(element: &Element, plugin: &str) -> Result<[f64; 3]> {
    let find = |name: &str| element.children.iter().find(|child| child.key().as_deref() == Some(name));
    let needs = |name: &str| element.error(format!("spectrum plugin `{plugin}` needs its parameter `{name}`"));
    match plugin {
        "uniform" => {
            let value = find("value").ok_or_else(|| needs("value"))?;
            Ok([numbers::one(value, value.required("value")?)?; 3])
        }
        "srgb" => parse_linear(find("color").ok_or_else(|| needs("color"))?),
        "d65" => match (find("color"), find("scale")) {
            (Some(color), None) => parse_linear(color),
            (None, Some(scale)) => Ok([numbers::one(scale, scale.required("value")?)?; 3]),
            (None, None) => Ok([1.0; 3]),
            (Some(_), Some(scale)) => {
                Err(scale.error("spectrum plugin `d65`: give either `color` or `scale`, not both"))
            }
        },
        _ => {
            let message = format!("spectrum plugin `{plugin}` is not supported; give the color as <rgb>");
            Err(element.error(message))
        }
    }
}

fn parse_linear(element: &Element) -> Result<[f64; 3]> {
    let value = element.required("value")?;
    match value.trim().starts_with('#') {
        true => Err(element.error(format!("`{value}` in <{}>: hex digits need <srgb>", element.tag))),
        false => numbers::one_or_three(element, value),
    }
}

fn parse_srgb(element: &Element) -> Result<[f64; 3]> {
    let value = element.required("value")?;
    match value.trim().strip_prefix('#') {
        Some(digits) => parse_hex(element, digits),
        None => numbers::one_or_three(element, value),
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
