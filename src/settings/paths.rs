//! Paths: their length, their random numbers, and what ends them.

use serde::{Deserialize, Serialize};

use super::{Learner, Sampler, Settings};
use crate::generated::constants;
use crate::generated::layout::PathVertex;
use crate::scene::Scene;
use crate::{Error, Result};

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

impl Settings {
    /// Quantity that Russian roulette uses. Where none is chosen, `product` uses the expected contribution, because its guide
    /// knows it. If no path is long enough for roulette by throughput, none is wanted, and throughput is the answer.
    pub fn roulette(&self) -> Roulette {
        let knows = self.sampler == Sampler::Product && self.rr_depth < self.max_depth;
        self.roulette.unwrap_or(if knows { Roulette::Contribution } else { Roulette::Throughput })
    }

    /// Number of vertices that a kernel keeps of a path.
    pub(crate) fn kept_vertices(&self) -> u32 {
        if self.learner == Learner::MonteCarlo { self.max_depth } else { 1 }
    }

    /// Bytes of the vertices that the learner keeps of each path in progress; 0 where it keeps none.
    pub fn path_bytes(&self) -> u64 {
        let keeps_vertices = self.sampler != Sampler::Bsdf && self.learner == Learner::MonteCarlo;
        if keeps_vertices { u64::from(self.kept_vertices()) * size_of::<PathVertex>() as u64 } else { 0 }
    }

    /// Refuses a scene with an emitter that no path can find.
    ///
    /// # Errors
    /// [`Error::Settings`] where emitters are not sampled and no ray can hit one of them.
    pub fn check_lighting(&self, scene: &Scene) -> Result<()> {
        match scene.delta_emitters.first() {
            Some(emitter) if !self.nee => Err(Error::Settings(format!(
                "the scene has a `{}` emitter, which no ray can hit: its light needs --nee on",
                emitter.kind.plugin()
            ))),
            _ => Ok(()),
        }
    }
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
