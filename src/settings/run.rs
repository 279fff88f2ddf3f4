//! The run: lengths of steps, weights of samples, and the kernels that trace the paths.

use serde::{Deserialize, Serialize};
use strum::{EnumMessage, IntoStaticStr, VariantArray};

/// Number of samples per pixel between two updates of the guide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum StepSchedule {
    /// A step as long as all steps before it, up to --spp-per-step samples: the guide learns early.
    Growing,
    /// Always --spp-per-step samples.
    Even,
}

/// Kernels that trace the paths. The picture is the same with each of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum Execution {
    /// The faster choice, by a rule: `wavefront` on a GPU with --nee on, if the scene has 10,000 primitives or more and the
    /// memory suffices; else `megakernel`.
    Auto,
    /// One kernel follows each path to its end.
    Megakernel,
    /// All paths advance by one edge, then by the next, with separate kernels for rays, lights and surfaces. The paths take
    /// memory: at most 1 GB or an eighth of the device's.
    Wavefront,
}

/// Ways of finding what a ray hits. The picture is the same with each of them, except where rounding decides which of two
/// primitives a ray hits.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray,
)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum Traversal {
    /// The project's own traversal, on any device.
    #[default]
    Compute,
    /// Ray queries of the device (VK_KHR_ray_query). Experimental: they have never run on a GPU with units for rays.
    Query,
    /// `query` on a GPU that has ray queries and room for the scene, else `compute`.
    Auto,
}

/// Weights of the samples in a pixel's mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum SampleWeights {
    /// Equal weights.
    Even,
    /// Smaller weights for samples of an early guide, by a schedule that is fixed before the render begins.
    Growing,
}
