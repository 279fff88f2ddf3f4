//! Uses of a texture's values.

/// Uses of a texture's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Color that should not exceed 1.
    Reflectance,
    /// Color without an upper limit.
    Absorption,
    /// Emitted light.
    Radiance,
    /// Number: the luminance of the color.
    Scalar,
    /// Number in [0, 1].
    Share,
    /// Heights, of which the slope matters.
    Heights,
    /// Normals in tangent space.
    Normals,
}

impl Role {
    /// Whether a number is used, not a color.
    pub fn is_number(self) -> bool {
        matches!(self, Self::Scalar | Self::Share | Self::Heights)
    }

    /// Whether a color is used.
    pub fn is_color(self) -> bool {
        matches!(self, Self::Reflectance | Self::Absorption | Self::Radiance)
    }

    /// Least and largest value of a computed texture.
    pub fn limits(self) -> [f32; 2] {
        match self {
            Self::Reflectance | Self::Share => [0.0, 1.0],
            Self::Scalar | Self::Absorption | Self::Radiance => [0.0, f32::MAX],
            Self::Heights | Self::Normals => [f32::MIN, f32::MAX],
        }
    }
}
