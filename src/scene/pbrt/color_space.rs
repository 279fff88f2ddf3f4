//! Color spaces in which a scene gives its colors.

use glam::{DMat3, DVec2, DVec3};

/// Chromaticity of D65, the white point of all the color spaces below but ACES.
const D65: DVec2 = DVec2::new(0.3127, 0.3290);
/// Chromaticity of the white point of ACES.
const ACES_WHITE: DVec2 = DVec2::new(0.32168, 0.33767);
/// Responses of the eye's cones to XYZ (Bradford), column by column. A change of the white scales them.
const CONES: DMat3 =
    DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);

/// Color space of a scene's colors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColorSpace {
    Srgb,
    DciP3,
    Rec2020,
    Aces2065,
}

impl ColorSpace {
    /// Color space that pbrt knows by `name`. The error says why it is not read.
    pub fn named(name: &str) -> Result<Self, String> {
        match name.to_ascii_lowercase().as_str() {
            "srgb" => Ok(Self::Srgb),
            "dci-p3" => Ok(Self::DciP3),
            "rec2020" => Ok(Self::Rec2020),
            "aces2065-1" => Ok(Self::Aces2065),
            other => {
                let other = super::tokens::brief(other);
                Err(format!("the color space `{other}` is not known; use `srgb`, `dci-p3`, `rec2020` or `aces2065-1`"))
            }
        }
    }

    /// Linear sRGB of the color of a light. The white of ACES is a little yellow.
    pub fn light_to_srgb(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Srgb => color,
            _ => (Self::Srgb.xyz_from_rgb().inverse() * self.xyz_from_rgb() * DVec3::from(color)).to_array(),
        }
    }

    /// Linear sRGB of the color of a material. White reflects all light, so it is white in every color space.
    pub fn to_srgb(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Aces2065 => {
                let [from, to] = [ACES_WHITE, D65].map(|white| CONES * xyz(white));
                let adapted = CONES.inverse() * DMat3::from_diagonal(to / from) * CONES;
                (Self::Srgb.xyz_from_rgb().inverse() * adapted * self.xyz_from_rgb() * DVec3::from(color)).to_array()
            }
            _ => self.light_to_srgb(color),
        }
    }

    /// Chromaticities of red, green and blue.
    fn primaries(self) -> [DVec2; 3] {
        let [red, green, blue] = match self {
            Self::Srgb => [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]],
            Self::DciP3 => [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06]],
            Self::Rec2020 => [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046]],
            Self::Aces2065 => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077]],
        };
        [red.into(), green.into(), blue.into()]
    }

    fn xyz_from_rgb(self) -> DMat3 {
        let [red, green, blue] = self.primaries().map(xyz);
        let columns = DMat3::from_cols(red, green, blue);
        let white = if self == Self::Aces2065 { ACES_WHITE } else { D65 };
        columns * DMat3::from_diagonal(columns.inverse() * xyz(white))
    }
}

/// XYZ of a chromaticity, with a luminance of 1.
fn xyz(at: DVec2) -> DVec3 {
    DVec3::new(at.x, at.y, 1.0 - at.x - at.y) / at.y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White stays white. The other numbers are those of ITU-R BT.2087 for BT.2020 to BT.709.
    #[test]
    fn colors_become_srgb() {
        let close = |found: [f64; 3], expected: [f64; 3]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?} is not {expected:?}");
        };
        for space in [ColorSpace::Srgb, ColorSpace::DciP3, ColorSpace::Rec2020, ColorSpace::Aces2065] {
            close(space.to_srgb([0.5; 3]), [0.5; 3]);
        }
        close(ColorSpace::Rec2020.to_srgb([1.0, 0.0, 0.0]), [1.6605, -0.1246, -0.0182]);
        close(ColorSpace::Rec2020.to_srgb([0.0, 1.0, 0.0]), [-0.5876, 1.1329, -0.1006]);
        close(ColorSpace::DciP3.to_srgb([1.0, 0.0, 0.0]), [1.2249, -0.0421, -0.0196]);
        // OpenColorIO's matrix of AP0 to linear Rec. 709, which adapts the white point by Bradford.
        close(ColorSpace::Aces2065.to_srgb([1.0, 0.0, 0.0]), [2.5217, -0.2765, -0.0154]);
        close(ColorSpace::Aces2065.to_srgb([0.0, 0.0, 1.0]), [-0.3876, -0.0962, 1.1684]);
        // The white of ACES as light: Y is 1, and X / Z those of its chromaticity.
        let white = ColorSpace::Aces2065.light_to_srgb([1.0; 3]);
        assert!(
            (crate::math::srgb::luminance(white) - 1.0).abs() < 1e-3 && white[0] > 1.04 && white[2] < 0.96,
            "{white:?}"
        );
    }
}
