//! Colors: numbers, spectra and temperatures as linear sRGB.
//!
//! pbrt scales every light that a spectrum or a temperature describes to a luminance of 1. A light of a color is the color times
//! the white of the color space, and white has a luminance of 1. So both become colors in linear sRGB.

use super::color_space::ColorSpace;
use super::files::Files;
use super::named_spectra;
use super::parameters::{Parameter, Values};
use super::tokens::brief;
use crate::Result;
use crate::math::srgb::luminance;
use crate::scene::spectrum;

/// Second radiation constant in nm K (CODATA).
const SECOND_RADIATION_CONSTANT: f64 = 1.438_776_877e7;

/// Color of a material. Channels that a spectrum or another color space makes negative become 0.
pub(super) fn of_material(parameter: &Parameter, space: ColorSpace, files: &mut Files) -> Result<[f64; 3]> {
    let color = match parameter.kind.as_str() {
        "rgb" | "color" => space.to_srgb(rgb(parameter)?),
        "spectrum" => match points(parameter, files)? {
            Spectrum::Points(points) => spectrum::of_material(&points),
            Spectrum::Named(name) => named_spectra::of_material(&name).ok_or_else(|| not_known(parameter, &name))?,
        },
        "blackbody" => return Err(parameter.error("is a temperature, but a material has none; give it an `rgb`")),
        other => {
            return Err(parameter.error(format!("should be `rgb`, `spectrum` or `texture`, not `{}`", brief(other))));
        }
    };
    Ok(color.map(|channel| channel.max(0.0)))
}

/// Color of a light, as bright as pbrt makes it before it applies the light's `scale`.
pub(super) fn of_light(parameter: &Parameter, space: ColorSpace, files: &mut Files) -> Result<[f64; 3]> {
    let color = match parameter.kind.as_str() {
        "rgb" | "color" => space.light_to_srgb(rgb(parameter)?),
        "blackbody" => normalized(spectrum::of_light(&blackbody(parameter)?)),
        "spectrum" => match points(parameter, files)? {
            Spectrum::Points(points) => normalized(spectrum::of_light(&points)),
            Spectrum::Named(name) => named_spectra::of_light(&name).ok_or_else(|| not_known(parameter, &name))?,
        },
        other => {
            return Err(parameter.error(format!("should be `rgb`, `spectrum` or `blackbody`, not `{}`", brief(other))));
        }
    };
    Ok(color.map(|channel| channel.max(0.0)))
}

/// Index of refraction, as one number. A spectrum is read at the sodium line; the flag says that it disperses light.
pub(super) fn index(parameter: &Parameter, files: &mut Files) -> Result<(f64, bool)> {
    const SODIUM: f64 = 587.6;
    if parameter.kind != "spectrum" {
        return Ok((parameter.number()?, false));
    }
    let points = match points(parameter, files)? {
        Spectrum::Named(name) => {
            let index = named_spectra::index(&name).ok_or_else(|| not_known(parameter, &name))?;
            return Ok((index, true));
        }
        Spectrum::Points(points) => points,
    };
    let after = points.partition_point(|point| point[0] < SODIUM).clamp(1, points.len() - 1);
    let ([x0, y0], [x1, y1]) = (points[after - 1], points[after]);
    let index = y0 + (y1 - y0) * ((SODIUM - x0) / (x1 - x0)).clamp(0.0, 1.0);
    Ok((index, points.iter().any(|point| point[1] != points[0][1])))
}

fn rgb(parameter: &Parameter) -> Result<[f64; 3]> {
    let color = parameter.three()?;
    match color.iter().find(|&&channel| channel < 0.0) {
        Some(channel) => Err(parameter.error(format!("must not be negative, as {channel} is"))),
        None => Ok(color),
    }
}

/// Color of luminance 1; black where there is no light.
fn normalized(color: [f64; 3]) -> [f64; 3] {
    let luminance = luminance(color);
    if luminance > 0.0 { color.map(|channel| channel / luminance) } else { [0.0; 3] }
}

/// Spectrum by its wavelengths, or by a name that pbrt knows.
enum Spectrum {
    Points(Vec<[f64; 2]>),
    Named(String),
}

fn points(parameter: &Parameter, files: &mut Files) -> Result<Spectrum> {
    let numbers = match &parameter.values {
        Values::Numbers(numbers) => numbers.clone(),
        _ => {
            let name = parameter.text()?;
            if named_spectra::is_known(name) {
                return Ok(Spectrum::Named(name.to_owned()));
            }
            let path = files.path(name);
            if !path.is_file() {
                return Err(not_known(parameter, name));
            }
            let text = files.text(&path)?;
            let words =
                text.lines().flat_map(|line| line.split('#').next().unwrap_or_default().split_ascii_whitespace());
            let number = |word: &str| word.parse().ok().filter(|number: &f64| number.is_finite());
            let numbers: Option<Vec<f64>> = words.map(number).collect();
            numbers.ok_or_else(|| {
                parameter.error(format!("names the file `{}`, which has something else than numbers", brief(name)))
            })?
        }
    };
    let (points, rest) = numbers.as_chunks::<2>();
    if points.len() < 2 || !rest.is_empty() {
        return Err(parameter.error("should be a spectrum: pairs of a wavelength and a value, two or more"));
    }
    if !points.is_sorted_by(|a, b| a[0] < b[0]) {
        return Err(parameter.error("has wavelengths that do not increase"));
    }
    Ok(Spectrum::Points(points.to_vec()))
}

fn not_known(parameter: &Parameter, name: &str) -> crate::Error {
    parameter.error(format!("names the spectrum `{}`, which is neither a file nor one that is known here", brief(name)))
}

/// Spectrum of a parameter's black body, up to a factor.
fn blackbody(parameter: &Parameter) -> Result<Vec<[f64; 2]>> {
    if let [_, _] = parameter.numbers()? {
        // pbrt-v3 took a factor, too.
        return Err(parameter.error(
            "has two numbers, but pbrt-v4 takes the temperature alone; give a factor as the light's \"float scale\"",
        ));
    }
    let temperature = parameter.number()?;
    if temperature <= 0.0 {
        return Err(parameter.error(format!("must be a temperature above 0, not {temperature}")));
    }
    Ok(planck(temperature))
}

/// Spectrum of a black body, up to a factor.
pub(super) fn planck(temperature: f64) -> Vec<[f64; 2]> {
    let point = |step| 360.0 + f64::from(step);
    (0..=470).map(|step| [point(step), planck_at(temperature, point(step))]).collect()
}

/// Planck's law at a wavelength in nm, relative to 560 nm, so that cold bodies keep numbers that are not 0.
pub(super) fn planck_at(temperature: f64, wavelength: f64) -> f64 {
    let exponent = SECOND_RADIATION_CONSTANT / temperature;
    let relative = (exponent / 560.0).exp_m1() / (exponent / wavelength).exp_m1();
    let value = (560.0 / wavelength).powi(5) * relative;
    if value.is_finite() { value } else { 0.0 }
}
