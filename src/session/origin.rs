//! The beginning of a session, to which it returns where a driver ends a loop of a kernel early.

use crate::renderer::RenderState;
use crate::renderer::guide_state::GuideState;
use crate::session::history::History;

/// Everything that a session begins again from.
#[derive(Default)]
pub(super) struct Origin {
    /// State and history of the checkpoint that a resumed render came from.
    pub checkpoint: Option<(RenderState, History)>,
    /// The guide that the render began with.
    pub guide: Option<GuideState>,
    /// Samples per pixel at which calls of [`Session::step`](crate::Session::step) ended, and steps with them.
    pub cuts: Vec<u32>,
}

impl Origin {
    /// Most samples of the next step, so that no step crosses the end of a call.
    pub fn samples_to_cut(&self, samples_done: u32) -> u32 {
        let cut = self.cuts.iter().find(|&&cut| cut > samples_done);
        cut.map_or(u32::MAX, |cut| cut - samples_done)
    }
}
