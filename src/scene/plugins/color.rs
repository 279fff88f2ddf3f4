//! Colors of parameters as linear sRGB.

use glam::Vec3;

use super::parameter::Parameter;
use crate::Result;
use crate::math::srgb::linear_from_srgb;
use crate::scene::description::kinds::Type;
use crate::scene::description::object::{Object, Spectrum, Value};
use crate::scene::folders::Folders;
use crate::scene::numbers;
use crate::scene::spectrum::{self, SpectrumUse};

/// Color that a parameter gives. Negative channels are an error.
pub(super) fn positive(parameter: Parameter, spectrum_use: SpectrumUse, folders: &Folders) -> Result<Vec3> {
    let color = signed(parameter, spectrum_use, folders)?;
    match color.to_array().iter().find(|&&channel| channel < 0.0) {
        Some(channel) => Err(parameter.error(format!("a color must not be negative, as {channel} is"))),
        None => Ok(color),
    }
}

/// Color whose channels may be negative, such as an index of refraction that a fit has left negative in one channel.
pub(super) fn signed(parameter: Parameter, spectrum_use: SpectrumUse, folders: &Folders) -> Result<Vec3> {
    let color = match parameter.value() {
        Value::Spectrum(Spectrum::Uniform(value)) => {
            let [value] = parameter.finite(&[*value])?;
            spectrum::uniform(value, spectrum_use)
        }
        Value::Spectrum(Spectrum::Points(points)) => over_wavelengths(parameter, points, spectrum_use)?,
        Value::Spectrum(Spectrum::File(name)) => {
            let message = |message| parameter.error(message);
            let points = spectrum::read_file(name, folders, &parameter.origin().file)?.map_err(message)?;
            over_wavelengths(parameter, &points, spectrum_use)?
        }
        Value::Srgb(color) => parameter.finite(color)?.map(linear_from_srgb),
        Value::Object(object) => of_plugin(object, spectrum_use)?,
        _ => linear(parameter)?,
    };
    Ok(Vec3::from_array(color.map(|channel| channel as f32)))
}

fn linear(parameter: Parameter) -> Result<[f64; 3]> {
    match parameter.value() {
        Value::Rgb(color) | Value::Spectrum(Spectrum::Rgb(color)) => parameter.finite(color),
        _ => Ok([parameter.number()?; 3]),
    }
}

/// Color of a spectrum over wavelengths. Negative channels become 0.
fn over_wavelengths(parameter: Parameter, points: &[[f64; 2]], spectrum_use: SpectrumUse) -> Result<[f64; 3]> {
    let word = || parameter.origin().word("spectrum");
    if points.len() < 2 {
        return Err(parameter.error(format!("a {} over wavelengths needs two or more of them", word())));
    }
    for point in points {
        parameter.finite(point)?;
    }
    match points.is_sorted_by(|a, b| a[0] < b[0]) {
        true => Ok(spectrum::reduced(points, spectrum_use).map(|channel| channel.max(0.0))),
        false => Err(parameter.error(format!("the wavelengths of a {} must increase", word()))),
    }
}

/// Color of a spectrum that is given as a plugin of Mitsuba 3. `uniform`, `srgb` and `d65` are exact in its rgb variants, where
/// `uniform` and `d65` are white also as emitted light. The others, which those variants lack, are spectra over wavelengths.
fn of_plugin(object: &Object, spectrum_use: SpectrumUse) -> Result<[f64; 3]> {
    let plugin = &object.plugin;
    let entry = |name: &str| object.entries.iter().find(|entry| entry.key() == name);
    let find = |name: &str| entry(name).map(|entry| Parameter { owner: object, entry });
    let needs = |name: &str| object.error(format!("spectrum plugin `{plugin}` needs its parameter `{name}`"));
    match &**plugin {
        "uniform" => Ok([find("value").ok_or_else(|| needs("value"))?.number()?; 3]),
        "srgb" => linear(find("color").ok_or_else(|| needs("color"))?),
        "d65" => match (find("color"), find("scale")) {
            (Some(color), None) => linear(color),
            (None, Some(scale)) => Ok([scale.number()?; 3]),
            (None, None) => Ok([1.0; 3]),
            (Some(_), Some(scale)) => {
                Err(scale.error("spectrum plugin `d65`: give either `color` or `scale`, not both"))
            }
        },
        "regular" => {
            let number = |name: &str| find(name).ok_or_else(|| needs(name))?.number();
            let values = find("values").ok_or_else(|| needs("values"))?;
            let (first, last, list) = (number("wavelength_min")?, number("wavelength_max")?, numbers_of(values)?);
            let step = (last - first) / list.len().saturating_sub(1).max(1) as f64;
            let points: Vec<_> =
                list.into_iter().enumerate().map(|(at, value)| [first + step * at as f64, value]).collect();
            over_wavelengths(values, &points, spectrum_use)
        }
        "irregular" => {
            let list = |name: &str| numbers_of(find(name).ok_or_else(|| needs(name))?);
            let values = find("values").ok_or_else(|| needs("values"))?;
            let (wavelengths, list) = (list("wavelengths")?, numbers_of(values)?);
            if wavelengths.len() != list.len() {
                let (few, many) = (list.len(), wavelengths.len());
                return Err(values.error(format!("spectrum plugin `irregular`: {few} values for {many} wavelengths")));
            }
            let points: Vec<_> = wavelengths.into_iter().zip(list).map(Into::into).collect();
            over_wavelengths(values, &points, spectrum_use)
        }
        _ => {
            let word = object.origin.word("rgb");
            Err(object.error(format!("spectrum plugin `{plugin}` is not supported; give the color as {word}")))
        }
    }
}

/// Numbers of a list, as text or as an array.
fn numbers_of(parameter: Parameter) -> Result<Vec<f64>> {
    match parameter.value() {
        Value::Text(text) => numbers::list(text).map_err(|message| parameter.error(message)),
        Value::Array(given) => Ok(given.clone()),
        Value::Vector(given) => Ok(given.to_vec()),
        _ => Err(parameter.mismatch(Type::String.name(), &parameter.entry.name)),
    }
}
