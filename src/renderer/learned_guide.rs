//! Guides that outlive their renderer: what one render has learned, as the beginning of another.

use glam::{DVec3, Vec3};

use super::Renderer;
use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::cosine_trees::{Node, nodes_per_tree};
use crate::encode::lights::group_nodes;
use crate::film::ranges::SampleRanges;
use crate::generated::kernels::{SHARE_WORDS, SHARES_PER_CELL};
use crate::generated::layout::{LearnedRadiance, NormalizationEntry};
use crate::math::direction_map::bin_center;
use crate::renderer::guide_cells::cells_of;
use crate::renderer::guide_state::{GuideState, check_learns_radiance, check_same_guide, least_bytes};
use crate::renderer::guide_tables::GuideTables;
use crate::renderer::persistent::Persistent;
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::renderer::state::{RenderState, StatePart};
use crate::settings::{Sampler, Settings};
use crate::{Error, Result};

/// Most bytes of a part after its content.
const MOST_PADDING: u64 = 1 << 16;

/// The radiance that a guide has learned, cell by cell and direction by direction.
#[derive(Debug, Clone)]
pub struct LearnedGuide {
    state: GuideState,
    radiance: Vec<f32>,
}

impl LearnedGuide {
    /// Lower and upper corner of every cell, world space.
    pub fn cells(&self) -> Vec<[Vec3; 2]> {
        self.state.cells.boxes()
    }

    /// Unit direction of the center of every bin, world space. Bins cover equal solid angles.
    pub fn directions(&self) -> Vec<DVec3> {
        let Settings { map, directions, .. } = self.state.settings;
        (0..directions.pow(2)).map(|bin| bin_center(map, bin, directions)).collect()
    }

    /// Bins along each side of the map of directions.
    pub fn side(&self) -> u32 {
        self.state.settings.directions
    }

    /// Learned radiance, W/(m^2 sr), the mean over RGB: `[cell][bin]`. Unless emitters are not sampled (`--nee off`), light that
    /// emitter sampling finds is left out.
    pub fn radiance(&self) -> &[f32] {
        &self.radiance
    }

    /// Learned radiance of the cell of a point, a bin after the other.
    pub fn radiance_at(&self, position: Vec3) -> &[f32] {
        let bins = self.state.settings.directions.pow(2) as usize;
        let begin = self.state.cells.cell_of(position) * bins;
        self.radiance.get(begin..begin + bins).unwrap_or_default()
    }

    pub(crate) fn state(&self) -> &GuideState {
        &self.state
    }
}

impl Renderer {
    /// Reads the guide back.
    ///
    /// # Errors
    /// Where the sampler learns no radiance, or the device is lost.
    pub fn learned_guide(&self) -> Result<LearnedGuide> {
        Ok(LearnedGuide { state: self.guide_state()?, radiance: self.radiance()? })
    }

    /// Reads the guide back as another render can begin with it.
    pub(super) fn guide_state(&self) -> Result<GuideState> {
        check_learns_radiance(&self.settings)?;
        let read = |part: &Persistent| Ok(StatePart { name: part.name.into(), bytes: part.read()? });
        let parts = self.guide_parts().iter().map(read).collect::<Result<_>>()?;
        let samples = self.guide_samples.clone().union(SampleRanges::of_render(&self.settings, self.samples_done));
        let (settings, cells) = (self.settings.clone(), self.cells.clone());
        let group_powers = self.sets.radiance_grid.group_powers().to_vec();
        Ok(GuideState { settings, cells, group_powers, parts, samples, is_bare: false })
    }

    /// Cells of a guide of this scene that has learned with other settings: the size of a picture may decide how fine its cells are.
    pub(crate) fn cells_of_guide(&self, settings: &Settings, bvh: &Bvh) -> Cells {
        cells_of(settings, bvh, &self.cells.media, self.light_groups())
    }

    /// The guide in the state of another render of this scene. `cells` are its cells, and `guide_samples` are the samples of earlier
    /// renders that it has learned from.
    ///
    /// # Errors
    /// Where the sampler learns no radiance, or the state holds no such guide.
    pub(crate) fn guide_of_state(
        &self,
        settings: Settings,
        cells: Cells,
        state: RenderState,
        guide_samples: SampleRanges,
    ) -> Result<GuideState> {
        check_learns_radiance(&settings)?;
        check_same_guide(&settings, &self.settings)?;
        let samples = guide_samples.union(SampleRanges::of_render(&settings, state.samples_done));
        let mut saved = state.parts;
        let mut take = |part: &Persistent| {
            let found = saved.iter().position(|saved| saved.name == part.name);
            let found = found.map(|found| saved.swap_remove(found));
            let found = found.filter(|found| found.bytes.len() as u64 >= self.least_bytes(part.name, &cells));
            found.ok_or_else(|| Error::Render(format!("the saved state lacks {} of this guide", part.name)))
        };
        let parts = self.guide_parts().iter().map(&mut take).collect::<Result<_>>()?;
        // Settings of the guide and the scene decide the groups of lights.
        let group_powers = self.sets.radiance_grid.group_powers().to_vec();
        Ok(GuideState { settings, cells, group_powers, parts, samples, is_bare: false })
    }

    /// The guide that a file holds.
    ///
    /// # Errors
    /// Where settings of the guides differ, or this sampler learns no radiance.
    pub(crate) fn guide_of_tables(&self, tables: GuideTables) -> Result<GuideState> {
        check_same_guide(&tables.settings, &self.settings)?;
        check_learns_radiance(&self.settings)?;
        Ok(tables.into_state())
    }

    /// What the guide has learned, for a file.
    ///
    /// # Errors
    /// Where the sampler learns no radiance, or the device is lost.
    pub fn guide_tables(&self) -> Result<GuideTables> {
        Ok(GuideTables::of_state(&self.guide_state()?))
    }

    /// Parts of a guide that was learned with these settings and in these cells: their names, and the most bytes of each.
    ///
    /// # Errors
    /// Where the sampler learns no radiance, or settings of the guides differ.
    pub(crate) fn most_bytes_of_guide(&self, settings: &Settings, cells: &Cells) -> Result<Vec<(&'static str, u64)>> {
        check_learns_radiance(settings)?;
        check_same_guide(settings, &self.settings)?;
        // Larger cells are fewer than those that they are made of, and buffers end with bytes that are never read.
        let most = |part: &Persistent| part.len_bytes().max(2 * self.least_bytes(part.name, cells) + MOST_PADDING);
        Ok(self.guide_parts().iter().map(|part| (part.name, most(part))).collect())
    }

    /// Bytes that are copied from one part of a guide of this scene in these cells.
    fn least_bytes(&self, part: &str, cells: &Cells) -> u64 {
        least_bytes(&self.settings, part, cells, self.light_groups())
    }

    /// Samples of earlier renders that the guide has learned from.
    pub(crate) fn guide_samples(&self) -> &SampleRanges {
        &self.guide_samples
    }

    /// Notes the samples of earlier renders that a restored guide has learned from.
    pub(crate) fn set_guide_samples(&mut self, samples: SampleRanges) {
        self.guide_samples = samples;
    }

    /// Begins with a guide of another render. Each cell takes what the nearest cell has learned. What it has learned about lights
    /// is left out if the groups of lights of the two scenes do not have the same powers.
    ///
    /// # Errors
    /// Where steps were taken already, settings of the guides differ, or the guide has learned from samples that this render may
    /// take.
    pub fn begin_with_guide(&mut self, guide: &LearnedGuide) -> Result<()> {
        self.begin_with_guide_state(&guide.state)
    }

    /// Begins with the guide that a file holds, as [`Renderer::begin_with_guide`] does.
    ///
    /// # Errors
    /// Where [`Renderer::begin_with_guide`] fails.
    pub fn begin_with_tables(&mut self, tables: GuideTables) -> Result<()> {
        let state = self.guide_of_tables(tables)?;
        self.begin_with_guide_state(&state)
    }

    /// Begins with the state of a guide, as [`Renderer::begin_with_guide`] does.
    pub(crate) fn begin_with_guide_state(&mut self, guide: &GuideState) -> Result<()> {
        let refuse = |message: String| Err(Error::Settings(message));
        if self.samples_done > 0 {
            return refuse("a render begins with a guide before its first step, but it has samples already".into());
        }
        check_same_guide(&guide.settings, &self.settings)?;
        let Settings { seed, sample_offset, .. } = self.settings;
        if let Some(end) = guide.samples.end(seed).filter(|&end| end > u64::from(sample_offset.unwrap_or(0))) {
            return refuse(format!(
                "the guide has learned from samples of --seed {seed} up to number {end} already, and a guide must not have learned \
                 from the samples that it guides; choose another seed, or a --sample-offset of at least {end}"
            ));
        }
        let centers = self.cells.boxes().into_iter().map(|[low, high]| 0.5 * (low + high));
        let sources: Vec<usize> = centers.map(|center| guide.cells.cell_of(center)).collect();
        let has_same_parts = guide.cells.are_those_of(&self.cells) && self.has_lights_of(guide);
        for (part, saved) in self.guide_parts().iter().zip(&guide.parts) {
            let length = part.len_bytes() as usize;
            let mut bytes = match has_same_parts {
                true => saved.bytes.clone(),
                false => self.copied_part(part, &saved.bytes, guide, &sources)?,
            };
            if bytes.len() > length {
                let (name, theirs) = (part.name, bytes.len());
                return Err(Error::Render(format!("the guide's {name} have {theirs} bytes, but only {length} fit")));
            }
            // Buffers are longer than their content by some bytes that are never read. A copy for other cells lacks the parent
            // cells, which are computed from their children below.
            bytes.resize(length, 0);
            part.write(&bytes)?;
        }
        if guide.is_bare || !has_same_parts {
            self.tabulate()?;
        }
        self.guide_samples = guide.samples.clone();
        Ok(())
    }

    /// Content of one part of another guide, for cells that take what `sources` have.
    fn copied_part(&self, part: &Persistent, bytes: &[u8], guide: &GuideState, sources: &[usize]) -> Result<Vec<u8>> {
        let Settings { sampler, directions, .. } = self.settings;
        let old_count = guide.cells.count() as usize;
        let bins = directions.pow(2) as usize;
        let normals = self.settings.normal_resolution().pow(2) as usize;
        Ok(match part.name {
            "radiance" => {
                let shares = if self.settings.learns_share() { (SHARE_WORDS * SHARES_PER_CELL) as usize } else { 0 };
                let (radiance, of_shares) = bytes.split_at(old_count * bins * size_of::<f32>());
                let mut copy = copied(radiance, bins * size_of::<f32>(), sources);
                copy.extend(copied(of_shares, shares * size_of::<f32>(), sources));
                copy
            }
            "learned radiance" => {
                let size = size_of::<LearnedRadiance>();
                let at = |cells: &Cells| RadianceGrid::learned_bins(&self.settings, cells) as usize * size;
                let tables =
                    [(0, 0, bins * size), (at(&guide.cells), at(&self.cells), self.light_groups() as usize * size)];
                self.copied_tables(part, bytes, guide, sources, tables)?
            }
            "bin ends" if sampler == Sampler::SphereInversion => copied(bytes, bins * size_of::<u32>(), sources),
            "radiance nodes" if sampler == Sampler::Product => {
                let tree = nodes_per_tree(directions) as usize * size_of::<Node>();
                let group_tree = group_nodes(self.light_groups()) as usize * size_of::<Node>();
                let tables = [(0, 0, tree), (old_count * tree, sources.len() * tree, group_tree)];
                self.copied_tables(part, bytes, guide, sources, tables)?
            }
            "normalizers" => copied(bytes, normals * size_of::<NormalizationEntry>(), sources),
            "marked normalizers" => copied_bits(bytes, normals, sources),
            _ => Vec::new(),
        })
    }

    /// Content of a part that holds a table of bins and a table of lights. Each has its place in the old part, its place in the
    /// new one, and the size of a cell's block. The table of lights stays as it is where the groups' powers differ.
    fn copied_tables(
        &self,
        part: &Persistent,
        bytes: &[u8],
        guide: &GuideState,
        sources: &[usize],
        tables: [(usize, usize, usize); 2],
    ) -> Result<Vec<u8>> {
        let mut content = part.read()?;
        for (old, new, size) in tables.into_iter().take(if self.has_lights_of(guide) { 2 } else { 1 }) {
            let copy = copied(&bytes[old..], size, sources);
            content[new..new + copy.len()].copy_from_slice(&copy);
        }
        Ok(content)
    }

    /// Whether a guide knows the groups of lights of this scene.
    fn has_lights_of(&self, guide: &GuideState) -> bool {
        guide.group_powers == self.sets.radiance_grid.group_powers()
    }

    /// Groups of lights among which each cell learns to choose.
    pub(super) fn light_groups(&self) -> u32 {
        self.sets.radiance_grid.group_powers().len() as u32
    }

    /// Memory of the device that the guide has between two steps.
    pub(super) fn guide_parts(&self) -> Vec<Persistent<'_>> {
        let radiance = self.sets.radiance_grid.persistent().into_iter();
        radiance.chain(self.sets.normalization_grid.persistent()).collect()
    }
}

/// Blocks of `size` bytes, one for each source.
fn copied(bytes: &[u8], size: usize, sources: &[usize]) -> Vec<u8> {
    sources.iter().flat_map(|source| &bytes[source * size..(source + 1) * size]).copied().collect()
}

/// Blocks of `size` bits, one for each source. The lowest bit of a byte is the first.
fn copied_bits(bytes: &[u8], size: usize, sources: &[usize]) -> Vec<u8> {
    let mut copy = vec![0; (size * sources.len()).div_ceil(8)];
    for (block, source) in sources.iter().enumerate() {
        for bit in 0..size {
            let (from, to) = (source * size + bit, block * size + bit);
            copy[to / 8] |= (bytes[from / 8] >> (from % 8) & 1) << (to % 8);
        }
    }
    copy
}
