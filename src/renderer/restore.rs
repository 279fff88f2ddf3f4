//! Reads the state of a renderer back, and goes on from one.

use super::Renderer;
use crate::renderer::film_store::FilmStore;
use crate::renderer::film_store::part_sums::PartSums;
use crate::renderer::persistent::Persistent;
use crate::renderer::state::{RenderState, StatePart};
use crate::{Error, Result};

impl Renderer {
    /// Reads back what complete steps have left. The state does not depend on how the film is cut into pages.
    ///
    /// # Errors
    /// Where the device is lost, or a step was stopped: some pixels then have samples of the step that others lack.
    pub fn state(&self) -> Result<RenderState> {
        self.check_whole()?;
        let read = |part: &Persistent| Ok(StatePart { name: part.name.into(), bytes: part.read()? });
        let parts: Result<Vec<_>> = self.persistent().iter().map(read).collect();
        let parts = parts?.into_iter().chain(self.host_part()).collect();
        Ok(RenderState { samples_done: self.samples_done, parts })
    }

    /// Refuses to keep the state of a step that was stopped.
    pub(crate) fn check_whole(&self) -> Result<()> {
        match self.stopped {
            true => Err(Error::Render("a step that was stopped cannot be gone on with later".into())),
            false => Ok(()),
        }
    }

    /// Names of the parts of a state, and their lengths in bytes.
    pub fn state_shape(&self) -> Vec<(String, u64)> {
        let of_device = self.persistent().into_iter().map(|part| (part.name.to_owned(), part.len_bytes()));
        of_device.chain(self.host_part().map(|part| (part.name, part.bytes.len() as u64))).collect()
    }

    /// Goes on from the state of a renderer of the same scene and settings: from here on both do the same to the last bit.
    ///
    /// # Errors
    /// Where the state does not fit the settings, or the device is lost.
    pub fn restore(&mut self, state: &RenderState) -> Result<()> {
        let shape = |parts: &[(String, u64)]| {
            parts.iter().map(|(name, bytes)| format!("{name}: {bytes} bytes")).collect::<Vec<_>>().join(", ")
        };
        let ours = self.state_shape();
        let theirs: Vec<_> = state.parts.iter().map(|part| (part.name.clone(), part.bytes.len() as u64)).collect();
        let persistent = self.persistent();
        if ours != theirs {
            let (theirs, ours) = (shape(&theirs), shape(&ours));
            return Err(Error::Render(format!("the saved state holds {theirs}, but this render has {ours}")));
        }
        persistent.iter().zip(&state.parts).try_for_each(|(part, saved)| part.write(&saved.bytes))?;
        if let (FilmStore::Part(sums), Some(saved)) = (&mut self.film_store, state.parts.last()) {
            sums.restore(&saved.bytes);
        }
        (self.samples_done, self.stopped, self.at_step_end) = (state.samples_done, false, true);
        self.choose_tiles()
    }

    /// Begins the render again, after a step that failed, with at most `samples_per_dispatch` samples in a dispatch. From here
    /// on a renderer that was made with that setting does the same to the last bit. `state` is the state to go on from;
    /// without one the render has no sample yet.
    ///
    /// # Errors
    /// Where the state does not fit the settings, or the device is lost.
    pub fn begin_again(&mut self, samples_per_dispatch: u32, state: Option<&RenderState>) -> Result<()> {
        self.settings.samples_per_dispatch = samples_per_dispatch;
        self.sets.radiance_grid.clear_sums(&self.context)?;
        if let Some(state) = state {
            return self.restore(state);
        }
        self.persistent().iter().try_for_each(Persistent::clear)?;
        self.sets.radiance_grid.begin_lights()?;
        if let FilmStore::Part(sums) = &mut self.film_store {
            *sums = PartSums::new(&self.settings);
        }
        (self.samples_done, self.stopped, self.at_step_end) = (0, false, true);
        self.warm_up()
    }

    /// The part of the state that the host's memory holds.
    fn host_part(&self) -> Option<StatePart> {
        let part = |sums: &PartSums| StatePart { name: "film sums".into(), bytes: sums.bytes().to_vec() };
        match &self.film_store {
            FilmStore::Part(sums) => Some(part(sums)),
            FilmStore::Plain | FilmStore::Adaptive(_) => None,
        }
    }

    /// Memory of the device that outlives a step. A complete step leaves no sums in a radiance grid, which has learned from
    /// them.
    fn persistent(&self) -> Vec<Persistent<'_>> {
        let film = self.sets.frame.persistent().into_iter();
        film.chain(self.sets.radiance_grid.persistent()).chain(self.sets.normalization_grid.persistent()).collect()
    }
}
