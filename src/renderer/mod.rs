//! The renderer: the paper's algorithm in safe code, one file per descriptor set.
//!
//! To understand the algorithm read [`Renderer::step`] in `step.rs`, `glsl/kernels/trace/trace.comp` and
//! `glsl/include/path/vertex.glsl`, in this order.
//!
//! | part | file |
//! |---|---|
//! | uploads and pipelines | `setup.rs`, `variants.rs`, `memory_needs.rs`, `guide_cells.rs` |
//! | one step, and its phases | `step.rs`, `phases.rs` |
//! | work that a fleet has each of its devices do | `shared.rs` |
//! | descriptor sets | `sets/` |
//! | tracing paths | `trace/` |
//! | learning between two steps | `learn/` |
//! | the film, and what a step's end does with it | `film_store/` |
//! | another camera or size, with the guide kept | `another_view.rs` |
//! | another scene, with what has not changed kept | `another_scene.rs` |
//! | what camera rays meet first, for compositors | `first_hits.rs` |
//! | state that a later render goes on from | `state.rs`, `restore.rs` |
//! | guides that later renders begin with | `guide_state.rs`, `learned_guide.rs`, `guide_tables.rs` (for files) |

pub(crate) mod another_scene;
pub(crate) mod another_view;
mod film_store;
pub mod first_hits;
mod guide_cells;
pub(crate) mod guide_state;
pub mod guide_tables;
mod learn;
pub mod learned_guide;
mod memory_needs;
mod persistent;
pub(crate) mod phases;
mod restore;
mod sets;
mod setup;
pub(crate) mod share;
pub(crate) mod shared;
mod state;
mod statistics;
mod step;
mod trace;
mod variants;

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;

pub use memory_needs::PictureWork;
pub use state::{RenderState, StatePart};
pub use statistics::{Counts, StepReport};
pub use variants::{variant_for, variant_of_settings};

use crate::Result;
use crate::encode::cells::Cells;
use crate::film::noise::NoiseReport;
use crate::film::ranges::SampleRanges;
use crate::film::{Picture, View};
use crate::generated::kernels::{BackEnd, Kernels, Variant};
use crate::gpu::Context;
use crate::renderer::film_store::FilmStore;
use crate::renderer::film_store::adaptive::Adaptive;
use crate::renderer::guide_cells::CellLimit;
use crate::renderer::learn::Learning;
use crate::renderer::memory_needs::MemoryNeeds;
use crate::renderer::sets::Sets;
use crate::renderer::trace::slices::Slicer;
use crate::renderer::trace::tracer::Tracer;
use crate::scene::{Camera, Crop};
use crate::settings::{Settings, Traversal};

/// Renders one scene on one device, step by step.
pub struct Renderer {
    context: Arc<Context>,
    settings: Settings,
    tracer: Tracer,
    slicer: Slicer,
    learning: Learning,
    film_store: FilmStore,
    cells: Cells,
    /// Film for which the cells were chosen. A change of the size keeps the cells.
    cells_are_for: CellLimit,
    sets: Sets,
    back_end: BackEnd,
    /// Kernels of the back end, and the constants with which those that trace are built.
    kernels: Kernels,
    variant: Variant,
    needs: MemoryNeeds,
    /// Whether the environment is seen behind the surfaces.
    has_background: bool,
    camera: Camera,
    /// `None` for a panorama.
    view: Option<View>,
    /// Samples of earlier renders that the guide has learned from.
    guide_samples: SampleRanges,
    samples_done: u32,
    stopped: bool,
    at_step_end: bool,
}

impl Renderer {
    /// Samples per pixel of the next step: by the schedule ([`Settings::samples_of_step`]), and more where noise has ended
    /// most of the picture.
    pub fn samples_of_next_step(&self) -> u32 {
        let usual = self.settings.samples_of_step(self.samples_done);
        let adaptive = self.film_store.adaptive();
        adaptive.map_or(usual, |adaptive| usual * adaptive.lengthening(self.samples_done, usual))
    }

    /// Whether every step was as long as the schedule has it. A longer render has then been in the same state.
    pub fn is_at_step_end(&self) -> bool {
        self.at_step_end && !self.stopped
    }

    /// Noise of the picture, where it ends the render ([`Settings::noise`]).
    pub fn noise(&self) -> Option<NoiseReport> {
        self.film_store.adaptive().map(Adaptive::report)
    }

    /// Pixels that are sampled: all, unless noise has ended some.
    pub fn sampled_pixels(&self) -> u64 {
        let Crop { width, height, .. } = self.settings.window();
        self.film_store.adaptive().map_or(u64::from(width) * u64::from(height), Adaptive::sampled_pixels)
    }

    /// The kind of buffers that the kernels read geometry and tables from.
    pub fn back_end(&self) -> BackEnd {
        self.back_end
    }

    /// The traversal that finds what rays hit, never [`Traversal::Auto`].
    pub fn traversal(&self) -> Traversal {
        if self.back_end == BackEnd::Query { Traversal::Query } else { Traversal::Compute }
    }

    /// Bytes of the guide on the device.
    pub fn guide_bytes(&self) -> u64 {
        guide_cells::guide_bytes(&self.settings, &self.cells, self.light_groups())
    }

    /// Samples per pixel that complete steps and dispatches have taken.
    pub fn samples_done(&self) -> u32 {
        self.samples_done
    }

    /// Whether the last step was stopped or has failed, so that no other can follow.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Reads the film back.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn picture(&self) -> Result<Picture> {
        self.picture_rows(&(0..self.settings.window().height))
    }

    /// Reads rows of the film back. The rows count from the window's first one.
    ///
    /// # Errors
    /// Where the device is lost.
    pub(crate) fn picture_rows(&self, rows: &Range<u32>) -> Result<Picture> {
        let picture = self.film_store.picture(&self.sets.frame, &self.settings, rows)?;
        Ok(Picture { has_background: self.has_background, view: self.view, ..picture })
    }

    /// Whether copies of the whole film are kept in the host's memory. Where it is the device's own, a copy of a large film would take as
    /// much again.
    pub(crate) fn has_copies(&self) -> bool {
        self.needs.has_copies(&self.settings)
    }

    /// Sentence about the memory that the render takes, if it is much.
    pub fn memory_note(&self) -> Option<String> {
        self.needs.note()
    }

    /// Number of samples that all pixels of the film have together.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn samples_in_film(&self) -> Result<u64> {
        self.film_store.samples(&self.sets.frame, &self.settings)
    }

    /// Learned radiance of the cells that hold surfaces, as the next step will sample it: `[cell][direction bin]`.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn radiance(&self) -> Result<Vec<f32>> {
        self.sets.radiance_grid.read()
    }

    /// Learned radiance of the cell of a point, a bin after the other; nothing without a guide.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn radiance_at(&self, position: Vec3) -> Result<Vec<f32>> {
        let bins = self.settings.directions.pow(2) as usize;
        let begin = self.cells.cell_of(position) * bins;
        Ok(self.radiance()?.into_iter().skip(begin).take(bins).collect())
    }

    /// Cells of the guide.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// Shares of the samples that each cell leaves to BSDFs: to diffuse lobes, and to BSDFs that are guided as a whole. Empty
    /// where shares are fixed.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn bsdf_shares(&self) -> Result<Vec<[f32; 2]>> {
        self.sets.radiance_grid.read_shares()
    }
}
