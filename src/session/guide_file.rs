//! Checkpoints of other renders, whose guides begin a render.

use std::path::PathBuf;

use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::film::ranges::SampleRanges;
use crate::fleet::Fleet;
use crate::session::options::Options;
use crate::session::running::Running;
use crate::session::saved::SavedCheckpoint;
use crate::session::start::Start;
use crate::{Error, Result};

/// A checkpoint whose guide begins a render.
pub(super) struct GuideFile {
    path: PathBuf,
    checkpoint: SavedCheckpoint,
}

impl GuideFile {
    /// Reads the checkpoint that the options name.
    pub fn of(start: &Start<'_>, options: &Options) -> Result<Option<Self>> {
        let Some(path) = options.guide_from.clone() else { return Ok(None) };
        if matches!(start, Start::Resume { .. }) {
            let message = "a render that goes on from its checkpoint has a guide already; leave --guide-from out";
            return Err(Error::Settings(message.into()));
        }
        let checkpoint = SavedCheckpoint::open(&path)?;
        if checkpoint.state.samples_done == 0 {
            return Err(Error::checkpoint(path, "its guide has learned nothing yet; give one with samples"));
        }
        Ok(Some(Self { path, checkpoint }))
    }

    /// Samples that the guide has learned from.
    pub fn samples(&self) -> SampleRanges {
        let SavedCheckpoint { settings, record, state, .. } = &self.checkpoint;
        record.guide_samples.clone().union(SampleRanges::of_render(settings, state.samples_done))
    }

    /// Refuses the guide of another scene.
    pub fn check_scene(&self, scene_hash: &str) -> Result<()> {
        let theirs = &self.checkpoint.scene;
        if theirs.hash == scene_hash {
            return Ok(());
        }
        let message = format!(
            "its guide was learned in another scene: scene_hash ({} there, {scene_hash} here), from {}; give a checkpoint of \
             this scene",
            theirs.hash, theirs.path
        );
        Err(Error::checkpoint(&self.path, message))
    }

    /// Cells of the guide in the scene of a fleet.
    pub fn cells(&self, fleet: &Fleet, bvh: &Bvh) -> Cells {
        fleet.first().cells_of_guide(&self.checkpoint.settings, bvh)
    }

    /// Begins a render with the guide, which has these cells.
    pub fn begin(self, cells: Cells, running: &mut Running) -> Result<()> {
        let Self { path, checkpoint: SavedCheckpoint { settings, state, record, .. } } = self;
        let begin = || {
            let most = running.renderer().most_bytes_of_guide(&settings, &cells)?;
            let state = state.read(|name, bytes| most.iter().any(|&(part, most)| part == name && bytes <= most))?;
            let guide = running.renderer().guide_of_state(settings, cells, state, record.guide_samples)?;
            running.begin_with_guide(guide)
        };
        begin().map_err(|error| match error {
            error @ Error::Checkpoint { .. } => error,
            error => Error::checkpoint(path, error.to_string()),
        })
    }
}
