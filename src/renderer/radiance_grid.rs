//! Set 2, RadianceGrid: what has been learned, L(cell, direction bin), and what the step under way adds to it. Or quadtrees of
//! directions, in the same buffers.

use std::sync::Arc;

use super::state::Persistent;
use super::{quadtrees, set_shape, table_kind, table_set};
use crate::Result;
use crate::cosine_trees::{Node, nodes_per_tree};
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet};
use crate::kernels::Kernels;
use crate::layout::{LearnedRadiance, RadianceSum};
use crate::settings::{Sampler, Settings};

/// The grid of Sec. 3: `grid^3` cells of `directions^2` bins.
pub(super) struct RadianceGrid {
    set: DescriptorSet,
    radiance: Arc<Buffer>,
    learned: Arc<Buffer>,
    /// Of a step, or with quadtrees of an iteration of steps.
    sums: Arc<Buffer>,
    keeps_sums: bool,
    /// Of sphere inversion alone.
    ends: Arc<Buffer>,
    /// Of the product sampler and of quadtrees alone.
    nodes: Arc<Buffer>,
    bin_count: usize,
}

impl RadianceGrid {
    /// Texels of the largest table.
    pub fn texels(settings: &Settings) -> u64 {
        Self::bins(settings).max(Self::nodes(settings))
    }

    fn bins(settings: &Settings) -> u64 {
        match settings.sampler {
            Sampler::Bsdf | Sampler::Quadtree => 0,
            _ => u64::from(settings.grid.pow(3)) * u64::from(settings.directions.pow(2)),
        }
    }

    fn sums(settings: &Settings) -> u64 {
        match settings.sampler {
            Sampler::Quadtree => quadtrees::quarters(settings),
            _ => Self::bins(settings),
        }
    }

    fn nodes(settings: &Settings) -> u64 {
        match settings.sampler {
            Sampler::Product => u64::from(settings.grid.pow(3)) * u64::from(nodes_per_tree(settings.directions)),
            Sampler::Quadtree => quadtrees::texels(settings),
            _ => 0,
        }
    }

    /// Bytes of the grid on the device.
    pub fn bytes(settings: &Settings) -> u64 {
        let end_bytes = if settings.sampler == Sampler::SphereInversion { size_of::<u32>() } else { 0 };
        let bin_bytes = Self::bins(settings) * (size_of::<f32>() + size_of::<LearnedRadiance>() + end_bytes) as u64;
        bin_bytes + Self::sums(settings) * size_of::<RadianceSum>() as u64 + Self::node_bytes(settings)
    }

    fn node_bytes(settings: &Settings) -> u64 {
        Self::nodes(settings) * size_of::<Node>() as u64
    }

    pub fn new(context: &Arc<Context>, kernels: &Kernels, settings: &Settings) -> Result<Self> {
        let shape = set_shape(kernels, 2);
        let bins = Self::bins(settings);
        let buffer = |name: &str, size: usize, kind| Buffer::new(context, name, bins * size as u64, kind);
        let radiance = buffer("radiance", size_of::<f32>(), table_kind(shape, BufferKind::StorageTexelFloat1))?;
        let learned = buffer("learned radiance", size_of::<LearnedRadiance>(), BufferKind::Storage)?;
        let sum_bytes = Self::sums(settings) * size_of::<RadianceSum>() as u64;
        let sums = Buffer::new(context, "radiance sums", sum_bytes, BufferKind::Storage)?;
        let ends = if settings.sampler == Sampler::SphereInversion { bins } else { 0 };
        let ends = Buffer::new(context, "bin ends", ends * size_of::<u32>() as u64, BufferKind::Storage)?;
        let node_kind = table_kind(shape, BufferKind::StorageTexelUint);
        let nodes = Buffer::new(context, "radiance nodes", Self::node_bytes(settings), node_kind)?;
        let buffers = [&radiance, &learned, &sums, &ends, &nodes, &radiance, &nodes];
        let set = table_set(context, "radiance grid", shape, &buffers)?;
        let keeps_sums = settings.sampler == Sampler::Quadtree;
        Ok(Self { set, radiance, learned, sums, keeps_sums, ends, nodes, bin_count: bins as usize })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }

    /// What outlives a step: its sums only where several steps add to them.
    pub fn persistent(&self) -> Vec<Persistent<'_>> {
        let sums = self.keeps_sums.then(|| Persistent { name: "radiance sums", buffers: vec![&self.sums] });
        let tables = [
            Persistent { name: "radiance", buffers: vec![&self.radiance] },
            Persistent { name: "learned radiance", buffers: vec![&self.learned] },
            Persistent { name: "bin ends", buffers: vec![&self.ends] },
            Persistent { name: "radiance nodes", buffers: vec![&self.nodes] },
        ];
        tables.into_iter().chain(sums).collect()
    }

    pub fn read(&self) -> Result<Vec<f32>> {
        self.radiance.read(0, self.bin_count)
    }
}
