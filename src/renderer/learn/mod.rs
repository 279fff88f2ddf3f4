//! Learning between two steps: recorded targets become the guide that the next step follows.

use std::sync::Arc;

use crate::Result;
use crate::generated::kernels::{Kernels, Variant};
use crate::gpu::Context;
use crate::renderer::learn::grid_updates::GridUpdates;
use crate::renderer::learn::refinement::Refinement;
use crate::settings::{Sampler, Settings};

pub(super) mod grid_updates;
pub(super) mod quadtrees;
pub(super) mod refinement;

/// The way in which the sampler's guide learns.
pub(crate) enum Learning {
    /// There is no guide.
    Nothing,
    /// The grids are updated after every step.
    Grids(Box<GridUpdates>),
    /// Quadtrees are refined after iterations of their own.
    Quadtrees(Refinement),
}

impl Learning {
    /// Builds the kernels that the settings ask for.
    pub fn new(context: &Arc<Context>, kernels: &Kernels, variant: &Variant, settings: &Settings) -> Result<Self> {
        Ok(match settings.sampler {
            Sampler::Bsdf => Self::Nothing,
            Sampler::Quadtree => Self::Quadtrees(Refinement::new(context, kernels, variant)?),
            _ => Self::Grids(Box::new(GridUpdates::new(context, kernels, variant, settings)?)),
        })
    }
}
