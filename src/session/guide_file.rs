//! Guides of other renders, from files, that begin a render.

use std::path::PathBuf;

use crate::encode::bvh::Bvh;
use crate::encode::cells::{Cells, Grid};
use crate::film::ranges::SampleRanges;
use crate::fleet::Fleet;
use crate::session::checkpoint::CHECKPOINT;
use crate::session::options::Options;
use crate::session::progress::Watch;
use crate::session::running::Running;
use crate::session::saved::SavedCheckpoint;
use crate::session::saved_guide::SavedGuide;
use crate::session::start::Start;
use crate::{Error, Result};

/// A file whose guide begins a render.
pub(super) struct GuideFile {
    path: PathBuf,
    content: Content,
}

/// Content of such a file.
enum Content {
    /// A guide alone, with its cells. It may be of another scene.
    Guide(Box<SavedGuide>),
    /// A checkpoint. Its cells follow from its scene, which must be that of the render.
    Checkpoint(Box<SavedCheckpoint>),
}

impl GuideFile {
    /// Opens the file that the options name.
    pub fn of(start: &Start<'_>, options: &Options) -> Result<Option<Self>> {
        let Some(path) = options.guide.clone() else { return Ok(None) };
        if matches!(start, Start::Resume { .. }) {
            let message = "a render that goes on from its checkpoint has a guide already; leave --guide out";
            return Err(Error::Settings(message.into()));
        }
        let content = match () {
            () if SavedGuide::is_in(&path)? => Content::Guide(SavedGuide::read(&path)?.into()),
            () if CHECKPOINT.is_of(&path)? => Content::Checkpoint(SavedCheckpoint::open(&path)?.into()),
            () => {
                let message = "it is no guide and no checkpoint; give a file of --guide-out, or a checkpoint";
                return Err(Error::checkpoint(path, message));
            }
        };
        let file = Self { path, content };
        if file.samples().first().is_none() {
            return Err(Error::checkpoint(file.path, "its guide has learned nothing yet; give one with samples"));
        }
        Ok(Some(file))
    }

    /// Samples that the guide has learned from.
    pub fn samples(&self) -> SampleRanges {
        match &self.content {
            Content::Guide(guide) => guide.tables.samples.clone(),
            Content::Checkpoint(checkpoint) => {
                let SavedCheckpoint { settings, record, state, .. } = &**checkpoint;
                record.guide_samples.clone().union(SampleRanges::of_render(settings, state.samples_done))
            }
        }
    }

    /// Refuses the checkpoint of another scene. Its camera and film may differ.
    pub fn check_scene(&self, world_hash: &str) -> Result<()> {
        let Content::Checkpoint(checkpoint) = &self.content else { return Ok(()) };
        let theirs = &checkpoint.scene;
        if theirs.world_hash == world_hash {
            return Ok(());
        }
        let message = format!(
            "its guide was learned in another scene: hash without camera and film ({} there, {world_hash} here), from {}; give a \
             file of --guide-out, which may be of another scene",
            theirs.world_hash, theirs.path
        );
        Err(Error::checkpoint(&self.path, message))
    }

    /// Cells of the guide.
    pub fn cells(&self, fleet: &Fleet, bvh: &Bvh) -> Cells {
        match &self.content {
            Content::Guide(guide) => guide.tables.cells.clone(),
            Content::Checkpoint(checkpoint) => fleet.first().cells_of_guide(&checkpoint.settings, bvh),
        }
    }

    /// Begins a render with the guide, which has these cells. Warns of the guide of another scene.
    pub fn begin(self, cells: Cells, world_hash: &str, running: &mut Running, watch: &Watch<'_>) -> Result<()> {
        let Self { path, content } = self;
        let begun = match content {
            Content::Guide(guide) => {
                let SavedGuide { scene, tables } = *guide;
                let here = running.renderer().cells().grid;
                let state = running.renderer().guide_of_tables(tables);
                let begun = state.and_then(|state| running.begin_with_guide(state));
                if begun.is_ok() && scene.hash != world_hash {
                    let bounds = difference_of_bounds(&cells.grid, &here);
                    watch.warn(&format!(
                        "{}: its guide was learned in another scene, {} (hash without camera and film: {} there, {world_hash} here; \
                         {bounds}): each cell takes what the nearest cell has learned, and the picture stays unbiased",
                        path.display(),
                        scene.name,
                        scene.hash,
                    ));
                }
                begun
            }
            Content::Checkpoint(checkpoint) => {
                let SavedCheckpoint { settings, state, record, .. } = *checkpoint;
                let begin = || {
                    let most = running.renderer().most_bytes_of_guide(&settings, &cells)?;
                    let state =
                        state.read(|name, bytes| most.iter().any(|&(part, most)| part == name && bytes <= most))?;
                    let guide = running.renderer().guide_of_state(settings, cells, state, record.guide_samples)?;
                    running.begin_with_guide(guide)
                };
                begin()
            }
        };
        begun.map_err(|error| match error {
            error @ Error::Checkpoint { .. } => error,
            error => Error::checkpoint(path, error.to_string()),
        })
    }
}

/// How the boxes of two scenes differ, as a clause.
fn difference_of_bounds(there: &Grid, here: &Grid) -> String {
    let [there, here] = [there, here].map(|grid| {
        let [low, high] = grid.bounds();
        format!("{low} to {high}")
    });
    if there == here { "the same bounds".into() } else { format!("bounds: {there} there, {here} here") }
}
