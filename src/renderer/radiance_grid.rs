//! Set 2, RadianceGrid: what has been learned, L(cell, direction bin), and what the step under way adds to it.

use std::sync::Arc;

use super::state::Persistent;
use super::{set_shape, table_kind, table_set};
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
    /// Of sphere inversion alone.
    ends: Arc<Buffer>,
    /// Of the product sampler alone.
    nodes: Arc<Buffer>,
    bin_count: usize,
}

impl RadianceGrid {
    /// Texels of the table, one a bin.
    pub fn texels(settings: &Settings) -> u64 {
        match settings.sampler {
            Sampler::Bsdf => 0,
            _ => u64::from(settings.grid.pow(3)) * u64::from(settings.directions.pow(2)),
        }
    }

    /// Bytes of the grid on the device.
    pub fn bytes(settings: &Settings) -> u64 {
        let end_bytes = if settings.sampler == Sampler::SphereInversion { size_of::<u32>() } else { 0 };
        let bin_bytes = size_of::<f32>() + size_of::<LearnedRadiance>() + size_of::<RadianceSum>() + end_bytes;
        Self::texels(settings).saturating_mul(bin_bytes as u64).saturating_add(Self::node_bytes(settings))
    }

    fn node_bytes(settings: &Settings) -> u64 {
        let nodes = if settings.sampler == Sampler::Product { nodes_per_tree(settings.directions) } else { 0 };
        u64::from(settings.grid.pow(3)) * u64::from(nodes) * size_of::<Node>() as u64
    }

    pub fn new(context: &Arc<Context>, kernels: &Kernels, settings: &Settings) -> Result<Self> {
        let shape = set_shape(kernels, 2);
        let bins = Self::texels(settings);
        let buffer = |name: &str, size: usize, kind| Buffer::new(context, name, bins * size as u64, kind);
        let radiance = buffer("radiance", size_of::<f32>(), table_kind(shape, BufferKind::StorageTexelFloat1))?;
        let learned = buffer("learned radiance", size_of::<LearnedRadiance>(), BufferKind::Storage)?;
        let sums = buffer("radiance sums", size_of::<RadianceSum>(), BufferKind::Storage)?;
        let ends = if settings.sampler == Sampler::SphereInversion { bins } else { 0 };
        let ends = Buffer::new(context, "bin ends", ends * size_of::<u32>() as u64, BufferKind::Storage)?;
        let node_kind = table_kind(shape, BufferKind::StorageTexelUint);
        let nodes = Buffer::new(context, "radiance nodes", Self::node_bytes(settings), node_kind)?;
        let buffers = [&radiance, &learned, &sums, &ends, &nodes, &radiance, &nodes];
        let set = table_set(context, "radiance grid", shape, &buffers)?;
        Ok(Self { set, radiance, learned, ends, nodes, bin_count: bins as usize })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }

    pub fn persistent(&self) -> [Persistent<'_>; 4] {
        [
            Persistent { name: "radiance", buffers: vec![&self.radiance] },
            Persistent { name: "learned radiance", buffers: vec![&self.learned] },
            Persistent { name: "bin ends", buffers: vec![&self.ends] },
            Persistent { name: "radiance nodes", buffers: vec![&self.nodes] },
        ]
    }

    pub fn read(&self) -> Result<Vec<f32>> {
        self.radiance.read(0, self.bin_count)
    }
}
