//! Samplers and learners, and the words that choose them.

use serde::{Deserialize, Serialize};
use strum::{EnumMessage, IntoStaticStr, VariantArray};

use crate::generated::constants::{self, Variant};

/// Source of scattered directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Sampler {
    /// The surface's BSDF times the cosine: an ordinary path tracer.
    Bsdf = constants::SAMPLER_BSDF,
    /// Rejection sampling of learned radiance times cosine, with the optimal share of uniform directions: the paper's "Rej+",
    /// Eq. 8.
    RejectionMix = constants::SAMPLER_REJECTION_MIX,
    /// Rejection sampling of learned radiance times cosine, with the least share of uniform directions.
    Rejection = constants::SAMPLER_REJECTION,
    /// Inversion of learned radiance over the whole sphere, without regard to the normal.
    SphereInversion = constants::SAMPLER_SPHERE_INVERSION,
    /// Inversion of learned radiance times the cosine's integral over each bin, summed for every sample.
    HemisphereInversion = constants::SAMPLER_HEMISPHERE_INVERSION,
    /// Learned radiance times cosine by a descent of fixed length, mixed with a share of the BSDF.
    Product = constants::SAMPLER_PRODUCT,
    /// Quadtrees of learned flux in the leaves of a binary tree, without regard to the normal, half and half with the BSDF
    /// (Müller, Gross and Novák 2017).
    Quadtree = constants::SAMPLER_QUADTREE,
}

impl Sampler {
    /// Learner of the sampler unless another is asked for.
    pub const fn default_learner(self) -> Learner {
        match self {
            Self::Quadtree => Learner::MonteCarlo,
            _ => Learner::Sarsa,
        }
    }

    /// Least share of uniform directions unless another is asked for. Inversion has no bound on the weight of a sample where the
    /// guide knows no light, so half of its directions are uniform: a sample is then weighted by at most four at each edge.
    pub const fn default_min_uniform(self) -> f32 {
        match self {
            Self::SphereInversion | Self::HemisphereInversion => 0.5,
            _ => Variant::DEFAULT.min_uniform_share,
        }
    }
}

/// Quantities that `rejection-mix` mixes with the uniform share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Mix {
    /// Densities (Eq. 8).
    Density = constants::MIX_DENSITY,
    /// Probabilities of acceptance (Eq. 9).
    Acceptance = constants::MIX_ACCEPTANCE,
}

/// BSDFs that are guided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum GuideSet {
    /// `diffuse`, `roughdiffuse` and the diffuse lobe of `plastic`, `roughplastic` and `pplastic`.
    Diffuse = constants::GUIDE_SET_DIFFUSE,
    /// The set `diffuse`, `roughconductor` and `roughdielectric`, which the code of the paper's authors guides.
    Authors = constants::GUIDE_SET_AUTHORS,
    /// The set `authors`, and `principled`. Rough conductors and dielectrics are guided by a share that grows with roughness.
    All = constants::GUIDE_SET_ALL,
}

/// Share of the samples that `product` draws from the BSDF; the guide draws the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum BsdfShare {
    /// One share everywhere: 0.25 or --epsilon.
    Fixed,
    /// A share that each cell learns, so that the mixture comes nearest to f cos L in Kullback-Leibler divergence. Diffuse lobes
    /// and BSDFs that are guided as a whole have shares of their own.
    Learned,
}

/// Probabilities with which emitter sampling draws lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum LightSelection {
    /// In proportion to the power of each light, everywhere.
    Power,
    /// Seven of eight draws in proportion to the light that a cell's surfaces have scattered from each light, the others by power and
    /// evenly. A few flat lights, and the environment, are cut into patches, which count as lights of their own.
    Learned,
}

/// Rule by which the radiance grid learns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum Learner {
    /// An edge reports the emission at its end, plus what the guide expects from the one direction sampled there (Eq. 6).
    Sarsa = constants::LEARNER_SARSA,
    /// Emission, plus what the guide expects from many directions, as a mean (Eq. 5).
    ExpectedSarsa = constants::LEARNER_EXPECTED_SARSA,
    /// The radiance that the rest of the path has collected.
    MonteCarlo = constants::LEARNER_MONTE_CARLO,
}
