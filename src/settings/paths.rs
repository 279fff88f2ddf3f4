//! Paths: their length, their random numbers and their Russian roulette.

use serde::{Deserialize, Serialize};
use strum::{EnumMessage, IntoStaticStr, VariantArray};

use crate::generated::constants;
use crate::scene::{IntegratorDescription, Scene};

/// Longest limit of paths that can be asked for, in edges.
pub const MAX_DEPTH_LIMIT: u32 = 1024;
/// Value of [`Settings::max_depth`](super::Settings::max_depth) that sets no limit: roulette ends every path.
pub const UNLIMITED_DEPTH: u32 = u32::MAX;
/// Edge from which roulette plays with every path of unlimited length. It is far beyond the light of most scenes, so that
/// roulette by contribution keeps its freedom there.
pub(super) const SURE_ROULETTE_DEPTH: u32 = 128;
/// Most vertices of a path that the learner `monte-carlo` keeps. It learns nothing for later vertices.
pub(super) const MOST_KEPT_VERTICES: u32 = 32;

/// Distribution of a pixel's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum SamplePattern {
    /// Independent random numbers for every sample.
    Independent = constants::PATTERN_INDEPENDENT,
    /// Owen-scrambled Sobol points in sets of eight samples, for every decision of a path. Camera rays continue along one
    /// sequence over all samples of a pixel.
    // A set ends where the guide is updated, so that every decision is independent of what the guide has learned.
    Sobol = constants::PATTERN_SOBOL,
    /// Sobol sets that the pixels of a tile share, so that the errors of neighboring pixels cancel: the noise is blue.
    BlueNoise = constants::PATTERN_BLUE_NOISE,
}

/// Quantity that Russian roulette compares with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Roulette {
    /// Throughput of the path, from the edge of --rr-depth on.
    Throughput = constants::ROULETTE_THROUGHPUT,
    /// Contribution that the guide expects of the rest of the path, relative to the value it expects of the pixel, from the
    /// first edge on (Vorba and Křivánek 2016). Surfaces without a guide use throughput.
    Contribution = constants::ROULETTE_CONTRIBUTION,
}

/// Warning for a scene whose depth is outside the range that can be rendered.
pub fn depth_warning(scene: &Scene) -> Option<String> {
    let IntegratorDescription { max_depth, rr_depth, .. } = scene.integrator;
    let too_long = |depth: &i32| u32::try_from(*depth).is_ok_and(|depth| depth > MAX_DEPTH_LIMIT);
    let unlimited = |depth| format!("the scene's max_depth of {depth} is rendered as unlimited");
    let bounded = |depth| format!("the scene's rr_depth of {depth} is rendered as {}", rr_depth_from_scene(depth));
    max_depth.filter(too_long).map(unlimited).or_else(|| rr_depth.filter(too_long).map(bounded))
}

/// Longest path of a scene. Mitsuba writes "unlimited" as -1, and takes it where the scene gives no `max_depth`.
pub(super) fn max_depth_from_scene(depth: Option<i32>) -> u32 {
    let limit = depth.and_then(|depth| u32::try_from(depth).ok()).filter(|&depth| depth <= MAX_DEPTH_LIMIT);
    limit.map_or(UNLIMITED_DEPTH, |depth| depth.max(1))
}

/// A scene's roulette depth in the range that can be rendered.
pub(super) fn rr_depth_from_scene(depth: i32) -> u32 {
    u32::try_from(depth).map_or(MAX_DEPTH_LIMIT, |depth| depth.clamp(1, MAX_DEPTH_LIMIT))
}
