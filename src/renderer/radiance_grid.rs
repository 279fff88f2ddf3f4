//! Set 2, RadianceGrid: what has been learned, L(cell, direction bin), and what the step under way adds to it.

use std::sync::Arc;

use super::set_shape;
use crate::Result;
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet};
use crate::kernels::Kernels;
use crate::layout::{LearnedRadiance, RadianceSum};
use crate::settings::{Sampler, Settings};

/// The grid of Sec. 3: `grid^3` cells of `directions^2` bins.
pub(super) struct RadianceGrid {
    set: DescriptorSet,
    radiance: Arc<Buffer>,
    bin_count: usize,
}

impl RadianceGrid {
    pub fn new(context: &Arc<Context>, kernels: &Kernels, settings: &Settings) -> Result<Self> {
        let bin_count = match settings.sampler {
            Sampler::Bsdf => 0,
            Sampler::RejectionMix => settings.grid.pow(3) as usize * settings.directions.pow(2) as usize,
        };
        let buffer = |name: &str, size: usize| Buffer::new(context, name, (bin_count * size) as u64, BufferKind::Storage);
        let radiance = buffer("radiance", size_of::<f32>())?;
        let learned = buffer("learned radiance", size_of::<LearnedRadiance>())?;
        let sums = buffer("radiance sums", size_of::<RadianceSum>())?;
        let set = DescriptorSet::new(context, "radiance grid", set_shape(kernels, 2), &[&radiance, &learned, &sums])?;
        Ok(Self { set, radiance, bin_count })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }

    pub fn read(&self) -> Result<Vec<f32>> {
        self.radiance.read(0, self.bin_count)
    }
}
