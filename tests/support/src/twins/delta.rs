//! Lobes of a single direction.

use glam::DVec3;

/// One direction that light may take, with its share of the samples and of the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeltaLobe {
    /// To the light.
    pub wi: DVec3,
    /// That a sample takes it.
    pub probability: f64,
    /// Radiance that goes to the eye over radiance that comes from there.
    pub value: DVec3,
    /// Index of refraction on the side of `wi` over that on the side of the eye.
    pub eta: f64,
}
