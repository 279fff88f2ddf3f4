//! The cells of a guide, and how many bytes it has.

use glam::{UVec3, Vec3};

use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::renderer::sets::normalization_grid::NormalizationGrid;
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::settings::{AUTO_GRID, Sampler, Settings};

/// Bytes of a guide for each pixel of the film, where the number of cells is chosen for the picture. A picture of more pixels
/// traces more paths, which can teach more cells, and a step of it takes longer, so that updates of more cells cost as little.
const BYTES_PER_PIXEL: u64 = 128;
/// Least and most bytes of such a guide. Between them are powers of two only, so that pictures of many sizes have the same cells, and what
/// one of them has learned suits the others.
const LEAST_BYTES: u64 = 8 << 20;
const MOST_BYTES: u64 = 64 << 20;

/// The cells of a render's grids, in a scene whose media lie in these boxes. Each learns to choose among `light_groups` groups of lights.
pub(super) fn cells_of(settings: &Settings, bvh: &Bvh, media: &[(Vec3, Vec3)], light_groups: u32) -> Cells {
    match settings.sampler {
        Sampler::Bsdf | Sampler::Quadtree => Cells::none(bvh),
        _ if settings.grid() != AUTO_GRID => Cells::new(bvh, media, UVec3::splat(settings.grid())),
        _ => {
            let fits = |cells: &Cells| guide_bytes(settings, cells, light_groups) <= bytes_for_picture(settings);
            Cells::fitting(bvh, media, fits)
        }
    }
}

/// What a film decides about the cells of a guide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CellLimit(u64);

impl CellLimit {
    pub fn of(settings: &Settings) -> Self {
        Self(bytes_for_picture(settings))
    }
}

/// Most bytes of a guide whose cells are chosen for the picture.
fn bytes_for_picture(settings: &Settings) -> u64 {
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    (BYTES_PER_PIXEL * pixels).clamp(LEAST_BYTES, MOST_BYTES).next_power_of_two()
}

/// Bytes of both grids.
pub(super) fn guide_bytes(settings: &Settings, cells: &Cells, light_groups: u32) -> u64 {
    RadianceGrid::bytes(settings, cells, light_groups).saturating_add(NormalizationGrid::bytes(settings, cells))
}
