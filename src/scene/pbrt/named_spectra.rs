//! Spectra that pbrt knows by name.

/// Metals and other conductors: index of refraction and extinction coefficient in linear sRGB, as the spectra that pbrt ships
/// look under D65. At normal incidence, they reflect the color that the spectra reflect, to within some hundredths.
#[rustfmt::skip]
const CONDUCTORS: [(&str, [f64; 3], [f64; 3]); 7] = [
    ("metal-Ag", [0.128347, 0.123395, 0.150714], [4.060675, 3.282514, 2.388917]),
    ("metal-Al", [1.405952, 0.925612, 0.583376], [7.732359, 6.595033, 5.353976]),
    ("metal-Au", [0.079871, 0.404652, 1.558968], [3.386746, 2.500706, 1.768912]),
    ("metal-Cu", [0.105056, 0.976819, 1.203228], [3.270163, 2.589603, 2.366343]),
    ("metal-CuZn", [0.417979, 0.519506, 1.121685], [3.663866, 2.677607, 1.769291]),
    ("metal-MgO", [1.731918, 1.738989, 1.751447], [0.0, 0.0, 0.0]),
    ("metal-TiO2", [2.857479, 2.953202, 3.181716], [0.000091, 0.0, 0.000566]),
];

/// Glasses: index of refraction at 587.6 nm.
const GLASSES: [(&str, f64); 7] = [
    ("glass-BK7", 1.5168),
    ("glass-BAF10", 1.67),
    ("glass-FK51A", 1.4866),
    ("glass-LASF9", 1.8503),
    ("glass-F5", 1.6727),
    ("glass-F10", 1.7283),
    ("glass-F11", 1.7847),
];

/// CIE and ACES illuminants: linear sRGB with a luminance of 1.
#[rustfmt::skip]
const ILLUMINANTS: [(&str, [f64; 3]); 16] = [
    ("stdillum-A", [1.845, 0.82607, 0.23346]),
    ("stdillum-D50", [1.08675, 0.99946, 0.74968]),
    ("stdillum-D65", [1.0, 1.0, 1.0]),
    ("stdillum-F1", [0.95356, 1.01965, 0.94218]),
    ("stdillum-F2", [1.33905, 0.9434, 0.56174]),
    ("stdillum-F3", [1.57515, 0.89154, 0.37987]),
    ("stdillum-F4", [1.80471, 0.83476, 0.26608]),
    ("stdillum-F5", [0.91484, 1.03653, 0.889]),
    ("stdillum-F6", [1.31522, 0.95818, 0.4855]),
    ("stdillum-F7", [1.00003, 1.00041, 0.99581]),
    ("stdillum-F8", [1.1766, 0.97585, 0.71889]),
    ("stdillum-F9", [1.37653, 0.9316, 0.56825]),
    ("stdillum-F10", [1.17632, 0.97612, 0.71702]),
    ("stdillum-F11", [1.41048, 0.92532, 0.5304]),
    ("stdillum-F12", [1.76624, 0.8458, 0.27007]),
    ("illum-acesD60", [1.04702, 0.99455, 0.91545]),
];

/// Whether a spectrum has this name.
pub(super) fn is_known(name: &str) -> bool {
    of_material(name).is_some() || of_light(name).is_some() || index(name).is_some()
}

/// Color of a conductor's spectrum, such as `metal-Cu-eta`.
pub(super) fn of_material(name: &str) -> Option<[f64; 3]> {
    let (metal, part) = name.rsplit_once('-')?;
    let (_, eta, k) = CONDUCTORS.iter().find(|(known, ..)| *known == metal)?;
    match part {
        "eta" => Some(*eta),
        "k" => Some(*k),
        _ => None,
    }
}

/// Color of an illuminant.
pub(super) fn of_light(name: &str) -> Option<[f64; 3]> {
    ILLUMINANTS.iter().find(|(known, _)| *known == name).map(|(_, color)| *color)
}

/// Index of refraction of a glass.
pub(super) fn index(name: &str) -> Option<f64> {
    GLASSES.iter().find(|(known, _)| *known == name).map(|(_, index)| *index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::srgb::luminance;

    #[test]
    fn illuminants_have_the_luminance_1() {
        for (name, color) in ILLUMINANTS {
            assert!((luminance(color) - 1.0).abs() < 1e-3, "{name}");
        }
    }

    /// Copper is red, gold is yellow: reflectances at normal incidence by Fresnel's equations.
    #[test]
    fn metals_have_their_colors() {
        let reflectance = |name: &str| {
            let (eta, k) = (of_material(&format!("{name}-eta")).unwrap(), of_material(&format!("{name}-k")).unwrap());
            [0, 1, 2].map(|c: usize| ((eta[c] - 1.0).powi(2) + k[c] * k[c]) / ((eta[c] + 1.0).powi(2) + k[c] * k[c]))
        };
        let close = |name, expected: [f64; 3]| {
            let found = reflectance(name);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.03), "{name}: {found:?}");
        };
        close("metal-Cu", [0.955, 0.638, 0.538]);
        close("metal-Au", [1.0, 0.782, 0.344]);
        close("metal-Ag", [0.972, 0.960, 0.915]);
        close("metal-Al", [0.913, 0.922, 0.924]);
    }
}
