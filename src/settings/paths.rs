//! Paths: their length, their random numbers and their Russian roulette.

use serde::{Deserialize, Serialize};

use crate::generated::constants;
use crate::scene::Scene;

/// Longest path that can be asked for, in edges. A scene's "unlimited" becomes this length.
pub const MAX_DEPTH_LIMIT: u32 = 1024;
/// Longest path whose vertices a learner can keep, in edges.
pub(super) const MAX_KEPT_VERTICES: u32 = 128;

/// Distribution of a pixel's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
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
    let named = [("max_depth", scene.integrator.max_depth), ("rr_depth", scene.integrator.rr_depth)];
    let (name, depth) = named.into_iter().find_map(|(name, depth)| {
        depth.filter(|&depth| depth != depth_from_scene(depth) as i32).map(|depth| (name, depth))
    })?;
    Some(format!("the scene's {name} of {depth} is rendered as {}", depth_from_scene(depth)))
}

/// Depth in the range that can be rendered; a negative depth means "unlimited".
pub(super) fn depth_from_scene(depth: i32) -> u32 {
    u32::try_from(depth).map_or(MAX_DEPTH_LIMIT, |depth| depth.clamp(1, MAX_DEPTH_LIMIT))
}
