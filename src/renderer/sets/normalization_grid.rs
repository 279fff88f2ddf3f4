//! Set 3, NormalizationGrid: memoised normalizers N(cell, normal bin), which entries are asked for, and the table of cosine
//! integrals they are computed from.

use std::sync::Arc;

use crate::Result;
use crate::encode::cells::Cells;
use crate::encode::cosine_integrals::cosine_integrals;
use crate::encode::cosine_trees::{Node, cosine_trees, nodes_per_tree};
use crate::generated::kernels::bindings::normalization_grid as numbers;
use crate::generated::kernels::{Kernels, NORMALIZATION_GRID_SET};
use crate::generated::layout::{CosineIntegral, NormalizationEntry};
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet};
use crate::renderer::persistent::Persistent;
use crate::renderer::sets::shapes::{set_over, set_shape, table_kind};
use crate::settings::{Sampler, Settings};

/// The grid of Sec. 4, with an entry per cell and normal bin.
pub(crate) struct NormalizationGrid {
    set: DescriptorSet,
    table: Arc<Buffer>,
    marks: Arc<Buffer>,
}

impl NormalizationGrid {
    /// Texels of the table. An entry has one.
    pub fn texels(settings: &Settings, cells: &Cells) -> u64 {
        u64::from(cells.count()) * u64::from(settings.normal_resolution().pow(2))
    }

    /// Bytes of the grid on the device. A mark is a bit, and every pair of bins has a cosine integral.
    pub fn bytes(settings: &Settings, cells: &Cells) -> u64 {
        let entries = Self::texels(settings, cells);
        let integrals = match settings.sampler {
            Sampler::Bsdf | Sampler::SphereInversion | Sampler::Quadtree => 0,
            _ => u64::from(settings.directions.pow(2)) * u64::from(settings.normals.pow(2)),
        };
        let integrals = integrals * size_of::<CosineIntegral>() as u64;
        let nodes = match settings.sampler {
            Sampler::Product => u64::from(nodes_per_tree(settings.directions)) * u64::from(settings.normals.pow(2)),
            _ => 0,
        };
        let tables = integrals + nodes * size_of::<Node>() as u64;
        entries.saturating_mul(size_of::<NormalizationEntry>() as u64).saturating_add(entries / 8 + tables)
    }

    pub fn new(context: &Arc<Context>, kernels: &Kernels, settings: &Settings, cells: &Cells) -> Result<Self> {
        let shape = set_shape(kernels, NORMALIZATION_GRID_SET);
        let entries = Self::texels(settings, cells);
        let cosines = match settings.sampler {
            Sampler::Bsdf | Sampler::SphereInversion | Sampler::Quadtree => Vec::new(),
            _ => cosine_integrals(settings.map, settings.directions, settings.normals),
        };
        let buffer = |name: &str, bytes: u64, kind| Buffer::new(context, name, bytes, kind);
        let table_bytes = entries * size_of::<NormalizationEntry>() as u64;
        let table = buffer("normalizers", table_bytes, table_kind(shape, BufferKind::StorageTexelUint))?;
        let marks = buffer("marked normalizers", entries.div_ceil(32) * size_of::<u32>() as u64, BufferKind::Storage)?;
        let integrals = Buffer::with_values(context, "cosine integrals", &cosines, BufferKind::Storage)?;
        let trees = match settings.sampler {
            Sampler::Product => cosine_trees(&cosines, settings.directions, settings.normals),
            _ => Vec::new(),
        };
        let node_kind = table_kind(shape, BufferKind::TexelUint);
        let trees = Buffer::with_values(context, "cosine nodes", &trees, node_kind)?;
        let buffers = [
            (numbers::NORMALIZATION_TABLE, &table),
            (numbers::NORMALIZATION_MARKS, &marks),
            (numbers::COSINE_INTEGRALS, &integrals),
            (numbers::NORMALIZATION_TEXELS, &table),
            (numbers::COSINE_NODES, &trees),
        ];
        let set = set_over(context, "normalization grid", shape, &buffers)?;
        Ok(Self { set, table, marks })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }

    /// Marks of the normalizers that were asked for, a bit each.
    pub fn marks(&self) -> &Buffer {
        &self.marks
    }

    pub fn persistent(&self) -> [Persistent<'_>; 2] {
        [Persistent::whole("normalizers", &self.table), Persistent::whole("marked normalizers", &self.marks)]
    }
}
