//! States and guides of a fleet: every device begins with them, and the first one gathers them.

use crate::film::ranges::SampleRanges;
use crate::fleet::Fleet;
use crate::fleet::command::{Command, lead};
use crate::renderer::RenderState;
use crate::renderer::guide_state::GuideState;
use crate::renderer::learned_guide::LearnedGuide;
use crate::scene::Camera;
use crate::{Error, Result};

impl Fleet {
    /// Reads back what complete steps have left, as one device would have it.
    ///
    /// # Errors
    /// Where a device is lost or a step was stopped.
    pub fn state(&self) -> Result<RenderState> {
        self.first.check_whole()?;
        lead(self.team.as_deref(), || Command::State, || self.gather_state())?;
        self.first.state()
    }

    /// Gathers everything that outlives a step on the first device of the first rank.
    pub(super) fn gather_state(&self) -> Result<()> {
        self.gather_film()?;
        if self.first.keeps_target_sums() && !self.is_alone() { self.gather_sums() } else { Ok(()) }
    }

    /// Goes on from the state of a renderer or a fleet of the same scene and settings: from here on both do the same to the last bit.
    ///
    /// # Errors
    /// Where the state does not fit the settings, or a device is lost.
    pub fn restore(&mut self, state: &RenderState) -> Result<()> {
        let team = self.team.clone();
        lead(team.as_deref(), || Command::Restore(state.clone()), || self.go_on_from(state))
    }

    /// Does this rank's part of going on from a state.
    pub(super) fn go_on_from(&mut self, state: &RenderState) -> Result<()> {
        self.all_mut().try_for_each(|device| device.restore(state))?;
        self.divide()
    }

    /// Begins the render again, as [`Renderer::begin_again`](crate::renderer::Renderer::begin_again) does.
    ///
    /// # Errors
    /// Where the state does not fit the settings, or a device is lost.
    pub fn begin_again(&mut self, samples_per_dispatch: u32, state: Option<&RenderState>) -> Result<()> {
        let team = self.team.clone();
        let command = || Command::BeginAgain { samples_per_dispatch, state: state.cloned() };
        lead(team.as_deref(), command, || self.start_over(samples_per_dispatch, state))
    }

    /// Does this rank's part of beginning again.
    pub(super) fn start_over(&mut self, samples_per_dispatch: u32, state: Option<&RenderState>) -> Result<()> {
        self.all_mut().try_for_each(|device| device.begin_again(samples_per_dispatch, state))?;
        self.divide()
    }

    /// Begins with a guide of another render on all devices, as
    /// [`Renderer::begin_with_guide`](crate::renderer::Renderer::begin_with_guide) does on one.
    ///
    /// # Errors
    /// Where steps were taken already, settings of the guides differ, or the guide has learned from samples that this render may
    /// take.
    pub fn begin_with_guide(&mut self, guide: &LearnedGuide) -> Result<()> {
        self.begin_with_guide_state(guide.state())
    }

    /// Begins with the state of a guide, as [`Fleet::begin_with_guide`] does.
    pub(crate) fn begin_with_guide_state(&mut self, guide: &GuideState) -> Result<()> {
        self.all_mut().try_for_each(|device| device.begin_with_guide_state(guide))?;
        match self.team {
            // The other ranks take over this guide.
            Some(_) => self.restore(&self.first.state()?),
            None => Ok(()),
        }
    }

    /// Shows the scene by another camera or on a film of another size on all devices, as
    /// [`Renderer::change_view`](crate::renderer::Renderer::change_view) does on one.
    ///
    /// # Errors
    /// Where [`Renderer::change_view`](crate::renderer::Renderer::change_view) fails, or ranks share the render.
    pub fn change_view(&mut self, camera: &Camera, size: [u32; 2]) -> Result<()> {
        if self.team.is_some() {
            let message = "ranks that share a render cannot change its camera or its size; begin another render";
            return Err(Error::Settings(message.into()));
        }
        let view = self.first.another_view(camera, size)?;
        self.all_mut().try_for_each(|device| device.change_view_to(&view))?;
        if self.is_alone() {
            return Ok(());
        }
        self.all().zip(self.shares()).try_for_each(|(device, &share)| device.deal(share))
    }

    /// Notes the samples of earlier renders that a restored guide has learned from.
    pub(crate) fn set_guide_samples(&mut self, samples: SampleRanges) {
        self.first.set_guide_samples(samples);
    }

    /// Divides up a state that all devices have begun with: the first device of the first rank keeps the sums, and the tiles that it has
    /// chosen are everybody's.
    fn divide(&mut self) -> Result<()> {
        if self.is_alone() {
            return Ok(());
        }
        let leads = self.leads();
        self.all().skip(usize::from(leads)).try_for_each(|device| device.clear_target_sums())?;
        self.share_tiles(Ok(()))
    }
}
