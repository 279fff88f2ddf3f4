//! One step of a fleet: the phases of a step on all devices, and what they exchange between two phases.

use std::sync::Arc;

use crate::Result;
use crate::fleet::Fleet;
use crate::fleet::command::{Command, lead};
use crate::renderer::phases::{Batch, Phase, phases};
use crate::renderer::{Counts, Renderer, StepReport};

impl Fleet {
    /// Takes `samples` more samples per pixel on all devices of all ranks, as [`Renderer::step`] does on one.
    ///
    /// # Errors
    /// Where [`Renderer::step`] fails on a device.
    pub fn step(&mut self, samples: u32, stop: &dyn Fn() -> bool) -> Result<StepReport> {
        if self.is_alone() {
            return self.first.step(samples, stop);
        }
        self.first.check_goes_on()?;
        let team = self.team.clone();
        lead(team.as_deref(), || Command::Step { samples }, || self.take_step(samples, stop))
    }

    /// Does this rank's part of a step.
    pub(super) fn take_step(&mut self, samples: u32, stop: &dyn Fn() -> bool) -> Result<StepReport> {
        let step = self.first.begin_step(samples)?;
        let mut counts = Counts::default();
        let complete = self.run_phases(samples, &mut counts, stop).map_err(|error| self.first.explain(error))?;
        Ok(self.first.end_step(&step, complete, counts))
    }

    /// Runs the phases of a step. Returns whether `stop` let all of them run.
    fn run_phases(&mut self, samples: u32, counts: &mut Counts, stop: &dyn Fn() -> bool) -> Result<bool> {
        for phase in phases(self.first.settings(), self.first.samples_done(), samples) {
            match phase {
                Phase::Trace(batch) => {
                    if !self.trace(batch, counts, stop)? {
                        return Ok(false);
                    }
                    self.all_mut().for_each(|device| device.note_samples(batch.end()));
                }
                Phase::Learn => {
                    self.add_up_sums()?;
                    self.on_every_device(Renderer::learn)?;
                }
                Phase::Settle => self.settle()?,
            }
        }
        Ok(true)
    }

    /// Adds a batch of samples to every pixel, on all devices of all ranks at the same time. Where `stop` answers true on the first
    /// rank or a device fails, all devices end after their dispatches under way. Returns whether all samples were taken.
    pub(super) fn trace(&mut self, batch: Batch, counts: &mut Counts, stop: &dyn Fn() -> bool) -> Result<bool> {
        let Some(team) = self.team.clone() else { return self.trace_on_devices(batch, counts, stop) };
        let mut own = Counts::default();
        let traced = self.trace_on_devices(batch, &mut own, &|| team.is_to_stop(stop));
        team.end_batch(traced, &own, counts, stop)
    }

    /// Ends a step for the film, which only the first device of the first rank has whole.
    fn settle(&mut self) -> Result<()> {
        if !self.first.settles_film() {
            return Ok(());
        }
        self.gather_film()?;
        let settled = if self.leads() { self.first.settle() } else { self.first.clear_part() };
        self.others.iter().try_for_each(Renderer::clear_part)?;
        self.share_tiles(settled)
    }

    /// Hands all devices the tiles that the first device of the first rank has chosen, where noise ends tiles. `chosen` is how that went.
    pub(super) fn share_tiles(&mut self, chosen: Result<()>) -> Result<()> {
        let own = self.first.tiles_going_on();
        if own.is_empty() {
            return chosen;
        }
        let tiles = match self.team.as_ref().map(Arc::clone) {
            None => chosen.map(|()| own)?,
            Some(team) => team.meet(chosen.map(|()| Vec::new()), &|| false, |_| Ok(own))?,
        };
        let leads = self.leads();
        self.all_mut().skip(usize::from(leads)).try_for_each(|device| device.go_on_with(&tiles))
    }
}
