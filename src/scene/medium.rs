//! Media: what fills the space between surfaces.

use glam::Vec3;

/// Homogeneous medium.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Medium {
    /// The medium's `id`, or its plugin and line, for messages.
    #[serde(skip)]
    pub name: String,
    /// Extinction coefficient, per scene unit, each channel >= 0.
    pub extinction: Vec3,
    /// Share of the extinction that is scattering, each channel in [0, 1].
    pub albedo: Vec3,
    /// Where scattered light goes.
    pub phase: Phase,
}

/// Phase function: a mixture of two lobes.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Phase {
    /// The lobes.
    pub lobes: [PhaseLobe; 2],
    /// Probability of the second lobe, in [0, 1].
    pub second_lobe: f32,
}

/// Lobe of a phase function.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum PhaseLobe {
    /// `hg` (Henyey and Greenstein 1941) with this mean cosine, in (-1, 1). With 0 it is `isotropic`.
    HenyeyGreenstein(f32),
    /// `rayleigh`.
    Rayleigh,
}

/// Media on the two sides of a surface; `None` is empty space. Indices into [`Media::all`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub struct Boundary {
    /// Medium on the side from which the geometric normal points away.
    pub interior: Option<u32>,
    /// Medium on the side to which the geometric normal points.
    pub exterior: Option<u32>,
}

/// Media of a scene.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Media {
    /// The media.
    pub all: Vec<Medium>,
    /// Medium around the camera.
    pub of_camera: Option<u32>,
}

impl Phase {
    /// Phase function of one lobe.
    pub fn of_lobe(lobe: PhaseLobe) -> Self {
        Self { lobes: [lobe; 2], second_lobe: 0.0 }
    }

    /// Scatters alike into all directions.
    pub fn isotropic() -> Self {
        Self::of_lobe(PhaseLobe::HenyeyGreenstein(0.0))
    }
}
