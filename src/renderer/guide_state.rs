//! A guide as another render can begin with it, and which guides suit a render.

use crate::encode::cells::Cells;
use crate::encode::cosine_trees::{Node, nodes_per_tree};
use crate::encode::lights::group_nodes;
use crate::film::ranges::SampleRanges;
use crate::generated::kernels::{SHARE_WORDS, SHARES_PER_CELL};
use crate::generated::layout::{LearnedRadiance, NormalizationEntry};
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::renderer::state::StatePart;
use crate::settings::{BsdfShare, LightSelection, Sampler, Settings};
use crate::{Error, Result};

/// A guide as another render can begin with it.
#[derive(Debug, Clone)]
pub(crate) struct GuideState {
    pub(super) settings: Settings,
    pub(super) cells: Cells,
    /// Power of each group of lights over that of all lights.
    pub(super) group_powers: Vec<f32>,
    pub(super) parts: Vec<StatePart>,
    /// Samples that it was learned from.
    pub(super) samples: SampleRanges,
    /// Whether it has only what was learned. The tables that samplers read are then computed.
    pub(super) is_bare: bool,
}

/// Bytes that are copied from one part of a guide in these cells, which choose among `light_groups` groups of lights.
pub(super) fn least_bytes(settings: &Settings, part: &str, cells: &Cells, light_groups: u32) -> u64 {
    let Settings { sampler, directions, .. } = *settings;
    let bins = directions.pow(2) as usize;
    let normals = settings.normal_resolution().pow(2) as usize;
    let per_cell = match part {
        "radiance" => {
            let shares = if settings.learns_share() { (SHARE_WORDS * SHARES_PER_CELL) as usize } else { 0 };
            (bins + shares) * size_of::<f32>()
        }
        "learned radiance" => {
            let lights = u64::from(cells.count()) * u64::from(light_groups);
            let means = RadianceGrid::learned_bins(settings, cells) + lights;
            return means * size_of::<LearnedRadiance>() as u64;
        }
        "bin ends" if sampler == Sampler::SphereInversion => bins * size_of::<u32>(),
        "radiance nodes" if sampler == Sampler::Product => {
            (nodes_per_tree(directions) + group_nodes(light_groups)) as usize * size_of::<Node>()
        }
        "normalizers" => normals * size_of::<NormalizationEntry>(),
        "marked normalizers" => return (u64::from(cells.count()) * normals as u64).div_ceil(8),
        _ => 0,
    };
    u64::from(cells.count()) * per_cell as u64
}

/// Refuses samplers whose guide cannot begin another render.
///
/// # Errors
/// [`Error::Settings`].
pub(crate) fn check_learns_radiance(settings: &Settings) -> Result<()> {
    let refuse = |message: &str| Err(Error::Settings(message.into()));
    match settings.sampler {
        Sampler::Bsdf => refuse("--sampler bsdf learns nothing, so there is no guide"),
        Sampler::Quadtree => refuse("--sampler quadtree learns flux, not radiance; choose another sampler"),
        _ => Ok(()),
    }
}

/// Refuses a guide that was learned with other settings than ours.
pub(super) fn check_same_guide(theirs: &Settings, ours: &Settings) -> Result<()> {
    let Some((name, theirs, ours)) = difference(theirs, ours) else { return Ok(()) };
    Err(Error::Settings(format!(
        "the guide was learned with another {name} ({theirs} there, {ours} here); choose the same"
    )))
}

/// Settings in which a default that a guide follows stands as if it had been given.
fn with_defaults(settings: Settings) -> Settings {
    let share = if settings.learns_share() { BsdfShare::Learned } else { BsdfShare::Fixed };
    let selection = if settings.learns_lights() { LightSelection::Learned } else { LightSelection::Power };
    Settings {
        grid: Some(settings.grid()),
        fallback: Some(settings.fallback()),
        bsdf_share: Some(share),
        light_selection: Some(selection),
        roulette: Some(settings.roulette()),
        ..settings
    }
}

/// First setting of the guide that differs: its name and both values. Settings of the film, the length and the samples do not
/// belong to the guide.
pub(super) fn difference(theirs: &Settings, ours: &Settings) -> Option<(String, String, String)> {
    let Settings { width, height, crop, filter, max_depth, rr_depth, hide_emitters, .. } = *ours;
    let Settings { seed, pattern, noise, sample_offset, spp_per_step, steps, sample_weights, .. } = *ours;
    let Settings { samples_per_dispatch, slice_milliseconds, execution, traversal, .. } = *ours;
    let theirs = Settings { width, height, crop, filter, max_depth, rr_depth, hide_emitters, ..theirs.clone() };
    let theirs = Settings { seed, pattern, noise, sample_offset, spp_per_step, steps, sample_weights, ..theirs };
    let theirs = with_defaults(Settings { samples_per_dispatch, slice_milliseconds, execution, traversal, ..theirs });
    let mut pairs = theirs.named().into_iter().zip(with_defaults(ours.clone()).named());
    pairs.find_map(|((name, theirs), (_, ours))| (theirs != ours).then_some((name, theirs, ours)))
}
