//! Uses of a texture's values.

/// Uses of a texture's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Color that should not exceed 1.
    Reflectance,
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

    /// Least and largest value of a computed texture.
    pub fn limits(self) -> [f32; 2] {
        match self {
            Self::Reflectance | Self::Share => [0.0, 1.0],
            Self::Scalar | Self::Radiance => [0.0, f32::MAX],
            Self::Heights | Self::Normals => [f32::MIN, f32::MAX],
        }
    }
}
