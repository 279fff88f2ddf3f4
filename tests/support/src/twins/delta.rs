//! Lobes of a single direction.

use glam::DVec3;

/// Single direction that light may take, with its share of the samples and of the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeltaLobe {
    /// Direction to the light.
    pub wi: DVec3,
    /// Probability that a sample takes this direction.
    pub probability: f64,
    /// Radiance towards the eye over radiance that arrives from `wi`.
    pub value: DVec3,
    /// Index of refraction on the side of `wi` over that on the side of the eye.
    pub eta: f64,
}
