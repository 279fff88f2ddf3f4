//! Color spaces in which a scene gives its colors.

use glam::{DMat3, DVec2, DVec3};

/// Chromaticity of D65, the white point of all the color spaces below.
const WHITE: DVec2 = DVec2::new(0.3127, 0.3290);

/// Color space of a scene's colors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColorSpace {
    Srgb,
    DciP3,
    Rec2020,
}

impl ColorSpace {
    /// Color space that pbrt knows by `name`. The error says why it is not read.
    pub fn named(name: &str) -> Result<Self, String> {
        match name.to_ascii_lowercase().as_str() {
            "srgb" => Ok(Self::Srgb),
            "dci-p3" => Ok(Self::DciP3),
            "rec2020" => Ok(Self::Rec2020),
            other => {
                let other = super::tokens::brief(other);
                Err(format!("the color space `{other}` is not supported; use `srgb`, `dci-p3` or `rec2020`"))
            }
        }
    }

    /// Linear sRGB of a color.
    pub fn to_srgb(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Srgb => color,
            _ => (Self::Srgb.xyz_from_rgb().inverse() * self.xyz_from_rgb() * DVec3::from(color)).to_array(),
        }
    }

    /// Chromaticities of red, green and blue.
    fn primaries(self) -> [DVec2; 3] {
        let [red, green, blue] = match self {
            Self::Srgb => [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]],
            Self::DciP3 => [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06]],
            Self::Rec2020 => [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046]],
        };
        [red.into(), green.into(), blue.into()]
    }

    fn xyz_from_rgb(self) -> DMat3 {
        let [red, green, blue] = self.primaries().map(xyz);
        let columns = DMat3::from_cols(red, green, blue);
        columns * DMat3::from_diagonal(columns.inverse() * xyz(WHITE))
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
        for space in [ColorSpace::Srgb, ColorSpace::DciP3, ColorSpace::Rec2020] {
            close(space.to_srgb([0.5; 3]), [0.5; 3]);
        }
        close(ColorSpace::Rec2020.to_srgb([1.0, 0.0, 0.0]), [1.6605, -0.1246, -0.0182]);
        close(ColorSpace::Rec2020.to_srgb([0.0, 1.0, 0.0]), [-0.5876, 1.1329, -0.1006]);
        close(ColorSpace::DciP3.to_srgb([1.0, 0.0, 0.0]), [1.2249, -0.0421, -0.0196]);
    }
}
