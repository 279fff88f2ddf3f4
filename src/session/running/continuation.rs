//! Links of a render to others: the checkpoint that it goes on from, the guide that it begins with, and the checkpoints of its own.

use std::path::Path;

use crate::renderer::RenderState;
use crate::renderer::guide_state::GuideState;
use crate::session::checkpoint::{Checkpoint, Record};
use crate::session::checkpoint_lock::CheckpointLock;
use crate::session::checkpoints::{CheckpointFile, Checkpoints};
use crate::session::devices::device_name;
use crate::session::history::History;
use crate::session::plan::Earlier;
use crate::session::progress::Watch;
use crate::session::running::Running;
use crate::session::saved_guide::{GuideScene, SavedGuide};
use crate::session::subject::Subject;
use crate::{Error, Result};

impl Running {
    /// Restores the state of a checkpoint and returns its number of samples per pixel.
    pub fn go_on_from(&mut self, earlier: Earlier, watch: &Watch<'_>) -> Result<u32> {
        let Earlier { record: Record { kernels, history, guide_samples, .. }, device, state, .. } = earlier;
        self.subject.check_kernels(&kernels)?;
        let own_device = device_name(&self.context);
        if device != own_device {
            watch.warn(&format!("the render began on {device}; on {own_device}, the last bits may differ"));
        }
        let state = state.read_as(&self.renderer().state_shape())?;
        self.fleet.restore(&state)?;
        self.fleet.set_guide_samples(guide_samples);
        let samples = state.samples_done;
        self.origin.checkpoint = Some((state, history.clone()));
        self.history = history;
        Ok(samples)
    }

    /// Begins with a guide, and keeps it in case the render must begin again.
    pub fn begin_with_guide(&mut self, guide: GuideState) -> Result<()> {
        self.fleet.begin_with_guide_state(&guide)?;
        let samples = self.fleet.first().guide_samples();
        self.checkpoints.iter_mut().for_each(|checkpoints| checkpoints.begin_with_guide(samples));
        self.origin.guide = Some(guide);
        Ok(())
    }

    /// Keeps checkpoints in `file`. If the file holds the render already, `samples_written` is its number of samples per pixel.
    pub fn keep_checkpoints(&mut self, file: CheckpointFile, samples_written: Option<u32>) -> Result<()> {
        self.checkpoints = Some(Checkpoints::new(file, self.template()?, samples_written));
        Ok(())
    }

    /// Writes a checkpoint of the render so far.
    pub fn write_checkpoint(&self, file: &Path) -> Result<()> {
        if !self.renderer().is_at_step_end() {
            let message = "the last step was shorter than the guide's schedule has it, and a checkpoint holds whole steps \
                           only; take whole steps";
            return Err(Error::checkpoint(file, message));
        }
        // The file may be that of a render which keeps its checkpoints there.
        let is_own = self.checkpoints.as_ref().is_some_and(|own| own.is_in(file));
        let _lock = if is_own { None } else { CheckpointLock::take(file)? };
        let mut checkpoint = self.template()?;
        (checkpoint.record.history, checkpoint.state) = (self.history.clone(), self.fleet.state()?);
        checkpoint.write(file)
    }

    /// Writes what the guide has learned so far.
    pub fn write_guide(&self, file: &Path) -> Result<()> {
        let tables = self.renderer().guide_tables()?;
        if tables.samples.first().is_none() {
            return Err(Error::checkpoint(
                file,
                "the guide has learned nothing yet, so it is not written; take samples first",
            ));
        }
        let Subject { scene_name, world_hash, .. } = &self.subject;
        let scene = GuideScene { name: scene_name.clone(), hash: world_hash.clone() };
        SavedGuide { scene, tables }.write(file)
    }

    /// A checkpoint of this render with nothing rendered yet.
    fn template(&self) -> Result<Checkpoint> {
        let scene = self.subject.scene_source()?;
        let outputs = self.output.pictures.to_absolute_paths()?;
        let (kernels, history) = (self.subject.kernels.clone(), History::default());
        let guide_samples = self.renderer().guide_samples().clone();
        let record = Record { length: self.length, outputs, kernels, history, guide_samples };
        let (settings, device) = (self.settings.clone(), device_name(&self.context));
        Ok(Checkpoint { scene, settings, device, record, state: RenderState::default() })
    }
}
