//! Set 2, RadianceGrid: the learned radiance L(cell, direction bin) and the targets that the step under way adds. The sampler
//! `quadtree` has its trees in the same buffers.

use std::sync::Arc;

use crate::Result;
use crate::encode::cells::Cells;
use crate::encode::cosine_trees::{Node, nodes_per_tree};
use crate::encode::lights::{Lights, first_weights, group_nodes, group_tree};
use crate::generated::kernels::bindings::radiance_grid as numbers;
use crate::generated::kernels::{Kernels, RADIANCE_GRID_SET, SHARE_SUMS, SHARE_WORDS, SHARES_PER_CELL};
use crate::generated::layout::{LearnedRadiance, RadianceSum};
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet};
use crate::renderer::learn::quadtrees;
use crate::renderer::persistent::Persistent;
use crate::renderer::sets::shapes::{set_over, set_shape, table_kind};
use crate::settings::{Sampler, Settings};

/// The grid of Sec. 3: cells of `directions^2` bins. The shares that cells leave to BSDFs follow the bins of all cells.
pub(crate) struct RadianceGrid {
    set: DescriptorSet,
    radiance: Arc<Buffer>,
    learned: Arc<Buffer>,
    /// Sums of a step's targets; with quadtrees, of an iteration's.
    sums: Arc<Buffer>,
    keeps_sums: bool,
    /// Ends of the bins' shares; for sphere inversion alone.
    ends: Arc<Buffer>,
    /// Nodes of trees; for the product sampler and quadtrees alone.
    nodes: Arc<Buffer>,
    bin_count: usize,
    share_count: usize,
    lights: LightTables,
}

/// Where the tables of groups of lights lie, and how they begin.
struct LightTables {
    /// Power of each group over that of all lights.
    powers: Vec<f32>,
    cell_count: usize,
    /// First node of the cells' group trees.
    first_node: u64,
    /// First of the powers among the learned means.
    first_power: u64,
}

impl RadianceGrid {
    /// Texels of the largest table.
    pub fn texels(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
        Self::radiances(settings, cells).max(Self::nodes(settings, cells, light_groups))
    }

    fn bins(settings: &Settings, cells: &Cells) -> u64 {
        u64::from(cells.count()) * u64::from(settings.directions.pow(2))
    }

    fn shares(settings: &Settings, cells: &Cells) -> u64 {
        if settings.learns_share() { u64::from(SHARES_PER_CELL) * u64::from(cells.count()) } else { 0 }
    }

    /// Groups of lights of all cells.
    fn lights(cells: &Cells, light_groups: u32) -> u64 {
        u64::from(cells.count()) * u64::from(light_groups)
    }

    /// Words of bins' ends.
    fn end_words(settings: &Settings, cells: &Cells) -> u64 {
        if settings.sampler == Sampler::SphereInversion { Self::bins(settings, cells) } else { 0 }
    }

    /// Words of the table that samplers read: means and shares.
    fn radiances(settings: &Settings, cells: &Cells) -> u64 {
        Self::bins(settings, cells) + u64::from(SHARE_WORDS) * Self::shares(settings, cells)
    }

    /// Bins that learn. Where cells borrow from the larger cells that they are part of, these learn, too.
    pub fn learned_bins(settings: &Settings, cells: &Cells) -> u64 {
        let count = if settings.fallback() > 0.0 { cells.all_count() } else { cells.count() };
        u64::from(count) * u64::from(settings.directions.pow(2))
    }

    /// Means that are learned: of bins, then of groups of lights. A last row of groups holds the power of each.
    fn learned_means(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
        Self::learned_bins(settings, cells) + Self::lights(cells, light_groups) + u64::from(light_groups)
    }

    fn sums(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
        match settings.sampler {
            Sampler::Quadtree => quadtrees::quarters(settings),
            _ => {
                let lights = Self::lights(cells, light_groups);
                Self::bins(settings, cells) + u64::from(SHARE_SUMS) * Self::shares(settings, cells) + lights
            }
        }
    }

    fn nodes(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
        match settings.sampler {
            Sampler::Product => {
                let nodes = nodes_per_tree(settings.directions) + group_nodes(light_groups);
                u64::from(cells.count()) * u64::from(nodes)
            }
            Sampler::Quadtree => quadtrees::texels(settings),
            _ => 0,
        }
    }

    /// Bytes of the grid on the device.
    pub fn bytes(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
        let words = Self::radiances(settings, cells) + Self::end_words(settings, cells);
        let learned = Self::learned_means(settings, cells, light_groups) * size_of::<LearnedRadiance>() as u64;
        let sums = Self::sums(settings, cells, light_groups) * size_of::<RadianceSum>() as u64;
        let table = size_of_val(&cells.table[..]) as u64;
        words * size_of::<u32>() as u64 + learned + sums + Self::node_bytes(settings, cells, light_groups) + table
    }

    fn node_bytes(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
        Self::nodes(settings, cells, light_groups) * size_of::<Node>() as u64
    }

    pub fn new(
        context: &Arc<Context>,
        kernels: &Kernels,
        settings: &Settings,
        cells: &Cells,
        lights: &Lights,
    ) -> Result<Self> {
        let light_groups = lights.group_count();
        let shape = set_shape(kernels, RADIANCE_GRID_SET);
        let bins = Self::bins(settings, cells);
        let buffer = |name: &str, count: u64, size: usize, kind| Buffer::new(context, name, count * size as u64, kind);
        let radiance_kind = table_kind(shape, BufferKind::StorageTexelFloat1);
        let radiance = buffer("radiance", Self::radiances(settings, cells), size_of::<f32>(), radiance_kind)?;
        let learned_means = Self::learned_means(settings, cells, light_groups);
        let learned = buffer("learned radiance", learned_means, size_of::<LearnedRadiance>(), BufferKind::Storage)?;
        let sum_count = Self::sums(settings, cells, light_groups);
        let sums = buffer("radiance sums", sum_count, size_of::<RadianceSum>(), BufferKind::Storage)?;
        let end_words = Self::end_words(settings, cells);
        let ends = buffer("bin ends", end_words, size_of::<u32>(), BufferKind::Storage)?;
        let node_kind = table_kind(shape, BufferKind::StorageTexelUint);
        let nodes = Buffer::new(context, "radiance nodes", Self::node_bytes(settings, cells, light_groups), node_kind)?;
        let table = Buffer::with_values(context, "cells", &cells.table, BufferKind::Storage)?;
        let buffers = [
            (numbers::RADIANCE_TABLE, &radiance),
            (numbers::LEARNED_TABLE, &learned),
            (numbers::RADIANCE_SUMS, &sums),
            (numbers::BIN_ENDS, &ends),
            (numbers::RADIANCE_NODES, &nodes),
            (numbers::RADIANCE_TEXELS, &radiance),
            (numbers::RADIANCE_NODE_TEXELS, &nodes),
            (numbers::CELL_TABLE, &table),
        ];
        let set = set_over(context, "radiance grid", shape, &buffers)?;
        let keeps_sums = settings.sampler == Sampler::Quadtree;
        let (bin_count, share_count) = (bins as usize, Self::shares(settings, cells) as usize);
        let lights = LightTables {
            powers: lights.group_powers(),
            cell_count: cells.count() as usize,
            first_node: u64::from(cells.count()) * u64::from(nodes_per_tree(settings.directions)),
            first_power: learned_means - u64::from(light_groups),
        };
        let grid = Self { set, radiance, learned, sums, keeps_sums, ends, nodes, bin_count, share_count, lights };
        grid.begin_lights()?;
        Ok(grid)
    }

    /// Makes all cells draw lights as before the first step: mostly in proportion to their power.
    pub fn begin_lights(&self) -> Result<()> {
        let LightTables { powers, cell_count, first_node, first_power } = &self.lights;
        if powers.is_empty() {
            return Ok(());
        }
        self.nodes
            .upload(first_node * size_of::<Node>() as u64, &group_tree(&first_weights(powers)).repeat(*cell_count))?;
        let powers: Vec<_> = powers.iter().map(|&mean| LearnedRadiance { mean, weight: 0.0 }).collect();
        self.learned.upload(first_power * size_of::<LearnedRadiance>() as u64, &powers)
    }

    /// Power of each group of lights over that of all lights.
    pub fn group_powers(&self) -> &[f32] {
        &self.lights.powers
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }

    /// Buffers that outlive a step. Sums do only where several steps add to them.
    pub fn persistent(&self) -> Vec<Persistent<'_>> {
        let sums = self.keeps_sums.then(|| Persistent::whole("radiance sums", &self.sums));
        let tables = [
            Persistent::whole("radiance", &self.radiance),
            Persistent::whole("learned radiance", &self.learned),
            Persistent::whole("bin ends", &self.ends),
            Persistent::whole("radiance nodes", &self.nodes),
        ];
        tables.into_iter().chain(sums).collect()
    }

    /// Sums of targets that have not been learned from yet.
    pub fn target_sums(&self) -> &Buffer {
        &self.sums
    }

    /// Whether sums outlive a step.
    pub fn keeps_sums(&self) -> bool {
        self.keeps_sums
    }

    /// Clears the sums of a step that failed.
    pub fn clear_sums(&self, context: &Arc<Context>) -> Result<()> {
        context.submit("clearing the sums", |recorder| recorder.fill_zero(&self.sums)).map(|_| ())
    }

    /// Reads the radiance of all bins.
    pub fn read(&self) -> Result<Vec<f32>> {
        self.radiance.read(0, self.bin_count)
    }

    /// Reads both shares of every cell.
    pub fn read_shares(&self) -> Result<Vec<[f32; 2]>> {
        let offset = (self.bin_count * size_of::<f32>()) as u64;
        let words = self.radiance.read::<[f32; SHARE_WORDS as usize]>(offset, self.share_count)?;
        Ok(words.chunks_exact(SHARES_PER_CELL as usize).map(|of_cell| [of_cell[0][0], of_cell[1][0]]).collect())
    }
}
