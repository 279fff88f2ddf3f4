//! Reads the state of a renderer back, and goes on from one.

use super::Renderer;
use crate::renderer::film_store::FilmStore;
use crate::renderer::film_store::part_sums::PartSums;
use crate::renderer::persistent::Persistent;
use crate::renderer::ranks::command::{Command, lead};
use crate::renderer::state::{RenderState, StatePart};
use crate::{Error, Result};

impl Renderer {
    /// Reads back what complete steps have left. The state does not depend on how the film is cut into pages.
    ///
    /// # Errors
    /// Where the device is lost, or a step was stopped: some pixels then have samples of the step that others lack.
    pub fn state(&self) -> Result<RenderState> {
        if self.stopped {
            return Err(Error::Render("a step that was stopped cannot be gone on with later".into()));
        }
        lead(self.team.as_deref(), || Command::State, || self.gather_state())?;
        self.gathered_state()
    }

    /// Gathers everything that outlives a step on the first device of the first rank.
    pub(super) fn gather_state(&self) -> Result<()> {
        self.gather_film()?;
        if self.sets.radiance_grid.keeps_sums() { self.gather_sums() } else { Ok(()) }
    }

    /// The state that this device holds.
    pub(super) fn gathered_state(&self) -> Result<RenderState> {
        let read = |part: &Persistent| Ok(StatePart { name: part.name.into(), bytes: part.read()? });
        let parts: Result<Vec<_>> = self.persistent().iter().map(read).collect();
        let parts = parts?.into_iter().chain(self.host_part()).collect();
        Ok(RenderState { samples_done: self.samples_done, parts })
    }

    /// Goes on from the state of a renderer of the same scene and settings: from here on both do the same to the last bit.
    ///
    /// # Errors
    /// Where the state does not fit the settings, or the device is lost.
    pub fn restore(&mut self, state: &RenderState) -> Result<()> {
        let team = self.team.clone();
        lead(team.as_deref(), || Command::Restore(state.clone()), || self.go_on_from(state))
    }

    /// Does this rank's part of going on from a state.
    pub(super) fn go_on_from(&mut self, state: &RenderState) -> Result<()> {
        for other in &mut self.others {
            other.go_on_from(state)?;
            other.sets.radiance_grid.clear_sums(&other.context)?;
        }
        let persistent = self.persistent();
        let shape = |parts: &[(&str, u64)]| {
            parts.iter().map(|(name, bytes)| format!("{name}: {bytes} bytes")).collect::<Vec<_>>().join(", ")
        };
        let host_part = self.host_part();
        let of_host = host_part.iter().map(|part| (&part.name[..], part.bytes.len() as u64));
        let ours: Vec<_> = persistent.iter().map(|part| (part.name, part.len_bytes())).chain(of_host).collect();
        let theirs: Vec<_> = state.parts.iter().map(|part| (&part.name[..], part.bytes.len() as u64)).collect();
        if ours != theirs {
            let (theirs, ours) = (shape(&theirs), shape(&ours));
            return Err(Error::Render(format!("the saved state holds {theirs}, but this render has {ours}")));
        }
        persistent.iter().zip(&state.parts).try_for_each(|(part, saved)| part.write(&saved.bytes))?;
        // The first device of the first rank keeps the sums of all.
        if !self.leads() {
            self.sets.radiance_grid.clear_sums(&self.context)?;
        }
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
        let team = self.team.clone();
        let command = || Command::BeginAgain { samples_per_dispatch, state: state.cloned() };
        lead(team.as_deref(), command, || self.start_over(samples_per_dispatch, state))
    }

    /// Does this rank's part of beginning again.
    pub(super) fn start_over(&mut self, samples_per_dispatch: u32, state: Option<&RenderState>) -> Result<()> {
        self.others.iter_mut().try_for_each(|other| other.start_over(samples_per_dispatch, state))?;
        self.settings.samples_per_dispatch = samples_per_dispatch;
        self.sets.radiance_grid.clear_sums(&self.context)?;
        if let Some(state) = state {
            return self.go_on_from(state);
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
