//! Spectra over wavelengths, reduced to linear sRGB as in Mitsuba's rgb variants.

use std::path::Path;

use super::folders::Folders;
use super::{color_matching, numbers};
use crate::scene::text;
use crate::{Result, inputs};

/// Uses of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SpectrumUse {
    /// Property of a material: seen under D65, the white point of linear sRGB.
    Material,
    /// Emitted light: seen directly by the standard observer.
    Emission,
}

/// Number of wavelengths at which Mitsuba evaluates a spectrum, evenly from the observer's first to last wavelength.
const SAMPLE_COUNT: usize = 1000;

/// Integral of the tabled `y` times D65, in nanometers.
const Y_INTEGRAL: f64 = 106.750_259_399_414_06;

/// Linear sRGB from CIE XYZ (IEC 61966-2-1, with Mitsuba's digits).
const SRGB_FROM_XYZ: [[f64; 3]; 3] =
    [[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556], [0.055648, -0.204043, 1.057311]];

/// Largest spectrum file in bytes; spectral measurements fit on a page of text.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// Unclamped linear sRGB of a material whose spectrum is given as wavelengths, which increase, and values.
pub(super) fn of_material(points: &[[f64; 2]]) -> [f64; 3] {
    reduced(points, SpectrumUse::Material)
}

/// Unclamped linear sRGB of light whose spectrum is given as wavelengths, which increase, and values.
pub(super) fn of_light(points: &[[f64; 2]]) -> [f64; 3] {
    reduced(points, SpectrumUse::Emission)
}

/// Share of each of these wavelengths, which increase, in the red, green and blue of a material's spectrum that has values at them. Beyond
/// its first and last wavelength the spectrum stays as it is there.
pub(super) fn material_weights(wavelengths: &[f64]) -> Vec<[f64; 3]> {
    let weight = |at: usize| {
        // The triangle of the wavelength among its neighbors.
        let first = at.saturating_sub(1);
        let last = (at + 1).min(wavelengths.len() - 1);
        let mut points: Vec<_> = (first..=last).map(|i| [wavelengths[i], if i == at { 1.0 } else { 0.0 }]).collect();
        if at == 0 && wavelengths[0] > color_matching::FIRST {
            points.insert(0, [color_matching::FIRST, 1.0]);
        }
        if at + 1 == wavelengths.len() && wavelengths[at] < color_matching::LAST {
            points.push([color_matching::LAST, 1.0]);
        }
        reduced(&points, SpectrumUse::Material)
    };
    (0..wavelengths.len()).map(weight).collect()
}

/// Color of a spectrum that is constant over all wavelengths.
pub(super) fn uniform(value: f64, spectrum_use: SpectrumUse) -> [f64; 3] {
    match spectrum_use {
        SpectrumUse::Material => [value; 3],
        // Equal energy: X = Y = Z.
        SpectrumUse::Emission => SRGB_FROM_XYZ.map(|row| value * row.iter().sum::<f64>()),
    }
}

/// Reads lines of a wavelength and a value from the file `name`, which the file `named_in` names; `#` starts a comment. The inner
/// error says what is wrong with the file.
pub(super) fn read_file(name: &str, folders: &Folders, named_in: &Path) -> Result<Result<Vec<[f64; 2]>, String>> {
    let Some(path) = folders.find(name, named_in) else {
        return Ok(Err(format!("the spectrum file `{name}` does not exist")));
    };
    let text = inputs::read(&path, MAX_FILE_BYTES)?;
    let Ok(text) = std::str::from_utf8(text::without_mark(&text)) else {
        return Ok(Err(format!("the spectrum file `{name}` is no text in UTF-8")));
    };
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let point = |line| match numbers::list(line)?[..] {
        [wavelength, value] => Ok([wavelength, value]),
        _ => Err(format!("each line of `{name}` should be a wavelength and a value")),
    };
    Ok(lines.map(point).collect())
}

/// Linear sRGB of a spectrum, which is zero outside the given wavelengths. As in Mitsuba, the 1000 samples lie on 999
/// intervals but are divided by 1000.
pub(super) fn reduced(points: &[[f64; 2]], spectrum_use: SpectrumUse) -> [f64; 3] {
    let (first, last) = (color_matching::FIRST, color_matching::LAST);
    let mut xyz = [0.0; 3];
    for i in 0..SAMPLE_COUNT {
        let wavelength = first + (last - first) * i as f64 / (SAMPLE_COUNT - 1) as f64;
        let Some(value) = interpolate(points, wavelength) else { continue };
        let [observer @ .., d65] = color_matching::at(wavelength);
        let light = if spectrum_use == SpectrumUse::Material { d65 } else { 1.0 };
        for (sum, response) in xyz.iter_mut().zip(observer) {
            *sum += response * value * light;
        }
    }
    let scale = (last - first) / SAMPLE_COUNT as f64 / Y_INTEGRAL;
    SRGB_FROM_XYZ.map(|row| scale * (0..3).map(|i| row[i] * xyz[i]).sum::<f64>())
}

fn interpolate(points: &[[f64; 2]], wavelength: f64) -> Option<f64> {
    let after = points.partition_point(|point| point[0] <= wavelength);
    match (points.get(after.wrapping_sub(1)), points.get(after)) {
        (Some([x0, y0]), Some([x1, y1])) => Some(y0 + (y1 - y0) * (wavelength - x0) / (x1 - x0)),
        (Some([x0, y0]), None) if *x0 == wavelength => Some(*y0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(color: [f64; 3], expected: [f64; 3]) {
        let close = color.iter().zip(expected).all(|(a, b)| (a - b).abs() < 6e-6);
        assert!(close, "{color:?} is not {expected:?}");
    }

    /// The expected numbers are those of Mitsuba 3.9.
    #[test]
    fn reduces_as_mitsuba_does() {
        let line = |a, b| [[400.0, a], [700.0, b]];
        assert_close(reduced(&line(0.5, 0.6), SpectrumUse::Material), [0.578086, 0.547524, 0.511059]);
        assert_close(reduced(&line(0.5, 2.5), SpectrumUse::Material), [2.10597, 1.45279, 0.769539]);
        assert_close(reduced(&line(0.5, 2.5), SpectrumUse::Emission), [2.48046, 1.3842, 0.679114]);
        assert_close(reduced(&[[500.0, 1.0], [600.0, 1.0]], SpectrumUse::Material), [0.209803, 1.02366, -0.0851368]);
        assert_close(uniform(2.0, SpectrumUse::Emission), [2.409588, 1.896582, 1.817832]);
        assert_close(uniform(2.0, SpectrumUse::Material), [2.0; 3]);
    }
}
