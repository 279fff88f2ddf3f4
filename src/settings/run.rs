//! The run: lengths of steps, weights of samples, and the kernels that trace the paths.

use serde::{Deserialize, Serialize};

use super::{Sampler, Settings, options};
use crate::Result;

/// Number of samples per pixel between two updates of the guide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum StepSchedule {
    /// A quarter of the samples taken so far, at least 1 and at most --spp-per-step: the guide learns early.
    Growing,
    /// Always --spp-per-step samples.
    Even,
}

/// Kernels that trace the paths. The picture is the same with each of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Execution {
    /// The faster choice: `wavefront` on a GPU that samples emitters among 10,000 primitives or more and has the memory,
    /// `megakernel` otherwise.
    Auto,
    /// One kernel follows each path to its end.
    Megakernel,
    /// All paths advance by one edge, then by the next, with separate kernels for rays, lights and surfaces. The paths take
    /// memory: at most 800 MiB or an eighth of the device's.
    Wavefront,
}

/// Weights of the samples in a pixel's mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SampleWeights {
    /// Equal weights.
    Even,
    /// Smaller weights for samples of an early guide, by a schedule that is fixed before the render begins.
    Growing,
}

impl Settings {
    /// Weights of the samples. Where none are chosen, `product` uses growing weights, unless parts of a picture are rendered or
    /// noise ends the render; everything else uses even weights.
    pub fn sample_weights(&self) -> SampleWeights {
        let grow = self.sampler == Sampler::Product && self.noise.is_none() && self.sample_offset.is_none();
        self.sample_weights.unwrap_or(if grow { SampleWeights::Growing } else { SampleWeights::Even })
    }

    /// Refuses settings whose paths cannot be traced as waves.
    pub(crate) fn check_wavefront(&self) -> Result<()> {
        options::check(&Self { execution: Execution::Wavefront, ..self.clone() })
    }
}
