//! Set 3, NormalizationGrid: memoised normalizers N(cell, normal bin), which entries are asked for, and the table of cosine
//! integrals they are computed from.

use std::sync::Arc;

use super::set_shape;
use crate::Result;
use crate::cosine_integrals::cosine_integrals;
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet};
use crate::kernels::Kernels;
use crate::layout::NormalizationEntry;
use crate::settings::{Sampler, Settings};

/// The grid of Sec. 4, with an entry per cell and normal bin.
pub(super) struct NormalizationGrid {
    set: DescriptorSet,
}

impl NormalizationGrid {
    pub fn new(context: &Arc<Context>, kernels: &Kernels, settings: &Settings) -> Result<Self> {
        let (entries, cosines) = match settings.sampler {
            Sampler::Bsdf => (0, Vec::new()),
            Sampler::RejectionMix => (
                settings.grid.pow(3) as usize * settings.normals.pow(2) as usize,
                cosine_integrals(settings.directions, settings.normals),
            ),
        };
        let buffer = |name: &str, bytes: usize| Buffer::new(context, name, bytes as u64, BufferKind::Storage);
        let table = buffer("normalizers", entries * size_of::<NormalizationEntry>())?;
        let marks = buffer("marked normalizers", entries.div_ceil(32) * size_of::<u32>())?;
        let integrals = buffer("cosine integrals", size_of_val(&cosines[..]))?;
        integrals.upload(0, &cosines)?;
        let set = DescriptorSet::new(context, "normalization grid", set_shape(kernels, 3), &[&table, &marks, &integrals])?;
        Ok(Self { set })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }
}
