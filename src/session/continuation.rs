//! What a later render begins with, on demand: a checkpoint of this one, or its guide.

use std::path::Path;

use crate::renderer::RenderState;
use crate::renderer::learned_guide::{GuideState, LearnedGuide};
use crate::scene::EnvironmentChoice;
use crate::session::checkpoint::{Checkpoint, Record, SceneSource};
use crate::session::files::absolute_path;
use crate::session::history::History;
use crate::session::run::Session;
use crate::{Error, Result};

impl Session {
    /// Writes a checkpoint of the render so far into `file`, from which [`Session::resume`] goes on to the same bits.
    ///
    /// # Errors
    /// Where the scene was made in memory, a step was shorter than the schedule has it, or the file cannot be written.
    pub fn write_checkpoint(&self, file: impl AsRef<Path>) -> Result<()> {
        if !self.fleet.first().is_at_step_end() {
            let message = "the last step was shorter than the guide's schedule has it, and a checkpoint holds whole steps \
                           only; take whole steps";
            return Err(Error::checkpoint(file, message));
        }
        let mut checkpoint = self.template()?;
        (checkpoint.record.history, checkpoint.state) = (self.history.clone(), self.fleet.state()?);
        checkpoint.write(file.as_ref())
    }

    /// The guide as it has been learned so far.
    ///
    /// # Errors
    /// Where the sampler learns no radiance, or the device is lost.
    pub fn learned_guide(&self) -> Result<LearnedGuide> {
        self.fleet.first().learned_guide()
    }

    /// Begins with a guide that another render has learned, of this scene or of one that differs little. Each cell takes what the
    /// nearest cell has learned. The picture stays unbiased.
    ///
    /// # Errors
    /// Where steps were taken already, settings of the guides differ, or the guide has learned from samples that this render may
    /// take: a guide must not have learned from the samples that it guides.
    pub fn begin_with_guide(&mut self, guide: &LearnedGuide) -> Result<()> {
        self.begin_with_guide_state(guide.state().clone())
    }

    /// Begins with a guide, and keeps it in case the render must begin again.
    pub(super) fn begin_with_guide_state(&mut self, guide: GuideState) -> Result<()> {
        self.fleet.begin_with_guide_state(&guide)?;
        let samples = self.fleet.first().guide_samples();
        self.checkpoints.iter_mut().for_each(|checkpoints| checkpoints.begin_with_guide(samples));
        self.origin.guide = Some(guide);
        Ok(())
    }

    /// A checkpoint of this render with nothing rendered yet.
    pub(super) fn template(&self) -> Result<Checkpoint> {
        let Some((path, options)) = &self.subject.source else {
            return Err(Error::Settings(
                "a checkpoint needs a scene that is read from a file, but this scene was made in memory".into(),
            ));
        };
        let hash = self.subject.scene_hash.clone();
        let mut options = options.clone();
        if let Some(EnvironmentChoice::File(path)) = &mut options.environment {
            *path = absolute_path(path)?.into();
        }
        let scene = SceneSource { path: absolute_path(path)?, options, hash };
        let outputs = self.output.pictures.to_absolute_paths()?;
        let (kernels, history) = (self.subject.kernels.clone(), History::default());
        let guide_samples = self.fleet.first().guide_samples().clone();
        let record = Record { length: self.length, outputs, kernels, history, guide_samples };
        let (settings, device) = (self.settings.clone(), self.device_name());
        Ok(Checkpoint { scene, settings, device, record, state: RenderState::default() })
    }
}
