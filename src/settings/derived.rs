//! Values that follow from several settings.

use super::flat::{AUTO_GRID, Settings};
use super::paths::{MAX_DEPTH_LIMIT, MOST_KEPT_VERTICES, Roulette, SURE_ROULETTE_DEPTH, UNLIMITED_DEPTH};
use super::run::SampleWeights;
use super::sampler::{BsdfShare, Learner, LightSelection, Sampler};
use crate::generated::layout::PathVertex;
use crate::scene::Scene;
use crate::{Error, Result};

/// Number of targets that a parent counts for with the sampler `product`.
const PRODUCT_FALLBACK: f32 = 16.0;
/// Cells along each axis of the paper's grid.
const PAPER_GRID: u32 = 8;

impl Settings {
    /// Quantity that Russian roulette compares with. Where none is chosen, `product` uses the expected contribution, because its
    /// guide knows it. If `rr_depth` is not below `max_depth`, the user wants no roulette; throughput then ends no path.
    pub fn roulette(&self) -> Roulette {
        let knows = self.sampler == Sampler::Product && self.rr_depth < self.max_depth;
        self.roulette.unwrap_or(if knows { Roulette::Contribution } else { Roulette::Throughput })
    }

    /// Cells along each axis of the grids, or [`AUTO_GRID`]. Where no number is chosen, `product` takes cells as fine as the picture
    /// can teach, if cells borrow from their parents. Everything else has the paper's grid.
    pub fn grid(&self) -> u32 {
        let borrows = self.sampler == Sampler::Product && self.fallback() > 0.0;
        self.grid.unwrap_or(if borrows { AUTO_GRID } else { PAPER_GRID })
    }

    /// Number of targets that the knowledge of a cell's parents counts for. Where none is chosen, `product` borrows from them.
    /// The other samplers are those of the paper, where cells do not.
    pub fn fallback(&self) -> f32 {
        self.fallback.unwrap_or(if self.sampler == Sampler::Product { PRODUCT_FALLBACK } else { 0.0 })
    }

    /// Most edges of a path that a kernel traces. Roulette ends paths of unlimited length long before: from
    /// [`SURE_ROULETTE_DEPTH`](super::paths) on a path survives each edge with a probability of at most 0.95, so that fewer than
    /// one path in 10^19 meets the bound.
    pub(crate) fn depth_bound(&self) -> u32 {
        if self.max_depth == UNLIMITED_DEPTH { MAX_DEPTH_LIMIT } else { self.max_depth }
    }

    /// Edge from which roulette may end any path. Only paths of unlimited length need it.
    pub(crate) fn sure_roulette_depth(&self) -> u32 {
        if self.max_depth == UNLIMITED_DEPTH { SURE_ROULETTE_DEPTH } else { u32::MAX }
    }

    /// Number of vertices that a kernel keeps of a path.
    pub(crate) fn kept_vertices(&self) -> u32 {
        if self.learner == Learner::MonteCarlo { self.max_depth.min(MOST_KEPT_VERTICES) } else { 1 }
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

    /// Whether cells learn the share of the BSDF. The sampler must be `product`, no fixed share may be chosen, and
    /// the learner must not be `monte-carlo`, which would need the share's statistics at every vertex.
    pub fn learns_share(&self) -> bool {
        let can = self.sampler == Sampler::Product && self.learner != Learner::MonteCarlo && self.epsilon.is_none();
        can && self.bsdf_share != Some(BsdfShare::Fixed)
    }

    /// Whether cells learn which lights to draw. The sampler must be `product`, and emitters must be sampled.
    pub fn learns_lights(&self) -> bool {
        self.sampler == Sampler::Product && self.nee && self.light_selection != Some(LightSelection::Power)
    }

    /// Number of normal bins that the sampler distinguishes, along each side of the equal-area square.
    pub(crate) fn normal_resolution(&self) -> u32 {
        if matches!(self.sampler, Sampler::SphereInversion | Sampler::Quadtree) { 1 } else { self.normals }
    }

    /// Weights of the samples. Where none are chosen, `product` uses growing weights, unless parts of a picture are rendered or
    /// noise ends the render; everything else uses even weights.
    pub fn sample_weights(&self) -> SampleWeights {
        let grow = self.sampler == Sampler::Product && self.noise.is_none() && self.sample_offset.is_none();
        self.sample_weights.unwrap_or(if grow { SampleWeights::Growing } else { SampleWeights::Even })
    }
}
