//! The cells of a guide, and how many bytes it has.

use glam::UVec3;

use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::renderer::sets::normalization_grid::NormalizationGrid;
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::settings::{AUTO_GRID, Sampler, Settings};

/// Most bytes of a guide whose cells are chosen by the scene.
const GUIDE_BYTES: u64 = 8 << 20;

/// The cells of a render's grids. Each learns to choose among `light_groups` groups of lights.
pub(super) fn cells_of(settings: &Settings, bvh: &Bvh, light_groups: u32) -> Cells {
    match settings.sampler {
        Sampler::Bsdf | Sampler::Quadtree => Cells::none(bvh),
        _ if settings.grid != AUTO_GRID => Cells::new(bvh, UVec3::splat(settings.grid)),
        _ => Cells::fitting(bvh, |cells| guide_bytes(settings, cells, light_groups) <= GUIDE_BYTES),
    }
}

/// Bytes of both grids.
pub(super) fn guide_bytes(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
    RadianceGrid::bytes(settings, cells, light_groups).saturating_add(NormalizationGrid::bytes(settings, cells))
}
