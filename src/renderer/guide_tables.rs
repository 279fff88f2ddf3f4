//! What a guide has learned, without the tables that samplers read: the content of a guide's file. CPU only.

use crate::encode::cells::Cells;
use crate::film::ranges::SampleRanges;
use crate::generated::kernels::{SHARE_WORDS, SHARES_PER_CELL};
use crate::generated::layout::LearnedRadiance;
use crate::renderer::guide_state::{GuideState, difference, least_bytes};
use crate::renderer::sets::radiance_grid::RadianceGrid;
use crate::renderer::state::StatePart;
use crate::settings::Settings;

/// Names of a guide's parts in the memory of a device, in their order.
const PARTS: [&str; 6] =
    ["radiance", "learned radiance", "bin ends", "radiance nodes", "normalizers", "marked normalizers"];
/// Largest sum that a guide may hold: of the weights of all bins, of their means times weights, and of the words of shares. The sums that
/// a device takes over cells and their parents are then finite.
const MOST_SUM: f64 = f32::MAX as f64 / 4.0;
/// Largest power of a group over that of all lights, which rounding may raise above 1.
const MOST_POWER: f32 = 1.001;

/// What a guide has learned, cell by cell.
#[derive(Debug, Clone, PartialEq)]
pub struct GuideTables {
    /// Settings with which it was learned.
    pub settings: Settings,
    /// Its cells, in world space.
    pub cells: Cells,
    /// Power of each group of lights over that of all lights.
    pub group_powers: Vec<f32>,
    /// Samples that it was learned from.
    pub samples: SampleRanges,
    /// Means and their weights: `[cell][direction bin]`.
    pub learned: Vec<LearnedRadiance>,
    /// Means and weights of groups of lights: `[cell][group]`.
    pub lights: Vec<LearnedRadiance>,
    /// Words of the shares that cells leave to BSDFs; empty where shares are fixed.
    pub shares: Vec<f32>,
    /// Normalizers that were asked for, a bit for each cell and normal bin.
    pub marks: Vec<u8>,
}

/// Numbers of values in the tables of a guide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableSizes {
    /// Means of bins.
    pub learned: u64,
    /// Means of groups of lights.
    pub lights: u64,
    /// Words of shares.
    pub shares: u64,
    /// Bytes of marks.
    pub marks: u64,
}

impl TableSizes {
    /// Sizes of a guide with these settings in `cells` cells, which choose among `light_groups` groups of lights.
    pub fn new(settings: &Settings, cells: u32, light_groups: u32) -> Self {
        let cells = u64::from(cells);
        let shares = if settings.learns_share() { u64::from(SHARE_WORDS * SHARES_PER_CELL) } else { 0 };
        Self {
            learned: cells * u64::from(settings.directions.pow(2)),
            lights: cells * u64::from(light_groups),
            shares: cells * shares,
            marks: (cells * u64::from(settings.normal_resolution().pow(2))).div_ceil(8),
        }
    }
}

impl GuideTables {
    /// Numbers of values in the tables.
    pub fn sizes(&self) -> TableSizes {
        TableSizes::new(&self.settings, self.cells.count(), self.group_powers.len() as u32)
    }

    /// Share of the cells that have learned from a target.
    pub fn learned_share(&self) -> f64 {
        let bins = self.settings.directions.pow(2) as usize;
        let has_learned = |of_cell: &&[LearnedRadiance]| of_cell.iter().any(|learned| learned.weight > 0.0);
        let taught = self.learned.chunks(bins).filter(has_learned).count();
        taught as f64 / f64::from(self.cells.count().max(1))
    }

    /// Whether all values are such as a render learns.
    pub fn are_sound(&self) -> bool {
        let is_in = |value: f32, most: f32| (0.0..=most).contains(&value);
        let bins = || self.learned.iter().chain(&self.lights);
        let is_finite = |sum: f64| sum <= MOST_SUM;
        let numbers = bins().flat_map(|bin| [bin.mean, bin.weight]).chain(self.shares.iter().copied());
        let weights = bins().map(|bin| f64::from(bin.weight)).sum();
        let radiance = bins().map(|bin| f64::from(bin.mean) * f64::from(bin.weight)).sum();
        let shares = self.shares.iter().map(|&word| f64::from(word)).sum();
        let lengths = TableSizes {
            learned: self.learned.len() as u64,
            lights: self.lights.len() as u64,
            shares: self.shares.len() as u64,
            marks: self.marks.len() as u64,
        };
        lengths == self.sizes()
            && numbers.into_iter().all(|number| is_in(number, f32::MAX))
            && [weights, radiance, shares].into_iter().all(is_finite)
            && self.group_powers.iter().all(|&power| is_in(power, MOST_POWER))
    }

    /// The tables of a guide that a device has held.
    pub(crate) fn of_state(state: &GuideState) -> Self {
        let GuideState { settings, cells, group_powers, parts, samples, .. } = state;
        let sizes = TableSizes::new(settings, cells.count(), group_powers.len() as u32);
        let bytes = |name: &str| parts.iter().find(|part| part.name == name).map_or(&[][..], |part| &part.bytes);
        let learned = |first: u64, count: u64| values(bytes("learned radiance"), first, count);
        Self {
            learned: learned(0, sizes.learned),
            lights: learned(RadianceGrid::learned_bins(settings, cells), sizes.lights),
            shares: values(bytes("radiance"), sizes.learned, sizes.shares),
            marks: values(bytes("marked normalizers"), 0, sizes.marks),
            settings: settings.clone(),
            cells: cells.clone(),
            group_powers: group_powers.clone(),
            samples: samples.clone(),
        }
    }

    /// The guide as a device can begin with it.
    pub(crate) fn into_state(self) -> GuideState {
        let Self { settings, cells, group_powers, samples, learned, lights, shares, marks } = self;
        let powers: Vec<_> = group_powers.iter().map(|&mean| LearnedRadiance { mean, weight: 0.0 }).collect();
        let parents = RadianceGrid::learned_bins(&settings, &cells) as usize - learned.len();
        let radiance = vec![0f32; learned.len()];
        let part = |name: &'static str| {
            let pieces: Vec<&[u8]> = match name {
                "radiance" => vec![bytemuck::cast_slice(&radiance), bytemuck::cast_slice(&shares)],
                "learned radiance" => {
                    let empty = size_of::<LearnedRadiance>() * parents;
                    let mut bytes = bytemuck::cast_slice(&learned).to_vec();
                    bytes.resize(bytes.len() + empty, 0);
                    bytes.extend_from_slice(bytemuck::cast_slice(&lights));
                    bytes.extend_from_slice(bytemuck::cast_slice(&powers));
                    return StatePart { name: name.into(), bytes };
                }
                "marked normalizers" => vec![&marks],
                _ => {
                    let bytes = least_bytes(&settings, name, &cells, group_powers.len() as u32);
                    return StatePart { name: name.into(), bytes: vec![0; bytes as usize] };
                }
            };
            StatePart { name: name.into(), bytes: pieces.concat() }
        };
        let parts = PARTS.into_iter().map(part).collect();
        GuideState { settings, cells, group_powers, parts, samples, is_bare: true }
    }

    /// First thing in which two guides differ that keeps them from being merged, as a clause.
    pub fn difference(&self, other: &Self) -> Option<String> {
        if let Some((name, theirs, ours)) = difference(&other.settings, &self.settings) {
            return Some(format!("they were learned with another {name} ({ours} and {theirs})"));
        }
        if !self.cells.are_those_of(&other.cells) {
            let [ours, theirs] = [self, other].map(|guide| guide.cells.grid.size);
            return Some(format!(
                "they have other cells ({} and {}, of {ours} and {theirs} places); give guides of pictures of one scene and \
                 one size",
                self.cells.count(),
                other.cells.count(),
            ));
        }
        (self.group_powers != other.group_powers).then(|| "their scenes have other lights".to_owned())
    }

    /// What several guides have learned together: means by their weights. The guides must not differ, and their samples must be disjoint.
    /// The order of the guides does not matter.
    pub fn merged(mut guides: Vec<Self>) -> Option<Self> {
        guides.sort_by_key(|guide| guide.samples.first());
        let mut merged = guides.first()?.clone();
        for (at, learned) in merged.learned.iter_mut().enumerate() {
            *learned = mean(guides.iter().map(|guide| guide.learned[at]));
        }
        for (at, light) in merged.lights.iter_mut().enumerate() {
            *light = mean(guides.iter().map(|guide| guide.lights[at]));
        }
        for (at, word) in merged.shares.iter_mut().enumerate() {
            let sum: f64 = guides.iter().map(|guide| f64::from(guide.shares[at])).sum();
            // The first word is the share itself, which the next update makes of the sums in the others.
            let is_share = at % SHARE_WORDS as usize == 0;
            *word = if is_share { sum / guides.len() as f64 } else { sum } as f32;
        }
        for guide in &guides[1..] {
            merged.marks.iter_mut().zip(&guide.marks).for_each(|(mark, other)| *mark |= other);
        }
        merged.samples = guides.into_iter().fold(SampleRanges::default(), |all, guide| all.union(guide.samples));
        Some(merged)
    }
}

/// Mean of several means by their weights, with the sum of the weights. Without weights it is their plain mean.
fn mean(of: impl Iterator<Item = LearnedRadiance>) -> LearnedRadiance {
    let (mut count, mut plain, mut sum, mut weight) = (0.0, 0.0, 0.0, 0.0);
    for learned in of {
        let (mean, its_weight) = (f64::from(learned.mean), f64::from(learned.weight));
        (count, plain, sum, weight) = (count + 1.0, plain + mean, sum + its_weight * mean, weight + its_weight);
    }
    let mean = if weight > 0.0 { sum / weight } else { plain / count };
    LearnedRadiance { mean: mean as f32, weight: weight as f32 }
}

/// `count` values from number `first` on. Values that are missing are left out.
fn values<T: bytemuck::AnyBitPattern>(bytes: &[u8], first: u64, count: u64) -> Vec<T> {
    let size = size_of::<T>();
    bytes.chunks_exact(size).skip(first as usize).take(count as usize).map(bytemuck::pod_read_unaligned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{UVec3, Vec3};

    use crate::encode::cells::Grid;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};

    fn guide(mean: f32, weight: f32, samples: &str) -> GuideTables {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        let settings = Settings { directions: 4, ..Settings::for_film(&film, &IntegratorDescription::default()) };
        let grid = Grid { origin: Vec3::ZERO, per_unit: Vec3::ONE, size: UVec3::new(3, 1, 1) };
        let cells = Cells::of_occupancy(grid, &[0b101]);
        let sizes = TableSizes::new(&settings, cells.count(), 2);
        GuideTables {
            settings,
            cells,
            group_powers: vec![0.25, 0.75],
            samples: samples.parse().unwrap(),
            learned: vec![LearnedRadiance { mean, weight }; sizes.learned as usize],
            lights: vec![LearnedRadiance { mean, weight }; sizes.lights as usize],
            shares: vec![weight; sizes.shares as usize],
            marks: vec![weight as u8; sizes.marks as usize],
        }
    }

    #[test]
    fn what_a_device_takes_comes_back() {
        let here = guide(2.0, 3.0, "7:0..64");
        assert!(here.are_sound());
        assert_eq!(GuideTables::of_state(&here.clone().into_state()), here);
    }

    #[test]
    fn means_are_merged_by_their_weights_in_any_order() {
        let [a, b, c] = [guide(2.0, 1.0, "7:0..64"), guide(5.0, 2.0, "7:64..128"), guide(9.0, 0.0, "3:0..8")];
        let merged = GuideTables::merged(vec![a.clone(), b.clone(), c.clone()]).unwrap();
        assert_eq!((merged.learned[0].mean, merged.learned[0].weight), (4.0, 3.0));
        assert_eq!((merged.lights[1].mean, merged.lights[1].weight), (4.0, 3.0));
        assert_eq!(merged.samples.to_string(), "3:0..8, 7:0..128");
        assert_eq!(merged.marks[0], 3);
        // The share itself is a mean, and the words behind it are sums.
        assert_eq!(merged.shares[..2], [1.0, 3.0]);
        assert_eq!(GuideTables::merged(vec![c.clone(), b.clone(), a.clone()]).unwrap(), merged);
        let nothing = GuideTables::merged(vec![c.clone(), c.clone()]).unwrap();
        assert_eq!((nothing.learned[0].mean, nothing.learned[0].weight), (9.0, 0.0));
        assert_eq!((a.learned_share(), c.learned_share()), (1.0, 0.0));
    }

    #[test]
    fn differences_are_named() {
        let here = guide(2.0, 1.0, "7:0..64");
        assert_eq!(here.difference(&guide(5.0, 2.0, "8:0..64")), None);
        let mut other = here.clone();
        other.settings.directions = 8;
        assert!(here.difference(&other).unwrap().contains("another directions"));
        let mut other = here.clone();
        other.cells = Cells::of_occupancy(here.cells.grid, &[0b111]);
        assert!(here.difference(&other).unwrap().contains("other cells (2 and 3"));
        let mut other = here.clone();
        other.group_powers.reverse();
        assert!(here.difference(&other).unwrap().contains("other lights"));
    }

    #[test]
    fn values_that_no_render_learns_are_found() {
        let changes: [fn(&mut GuideTables); 9] = [
            |guide| guide.learned[3].mean = f32::NAN,
            |guide| guide.learned[3].weight = -1.0,
            |guide| guide.lights[0].mean = f32::INFINITY,
            |guide| guide.lights[0].weight = f32::MAX,
            |guide| guide.learned[1].mean = 1.0e38,
            |guide| guide.shares.fill(1.0e38),
            |guide| guide.shares[1] = f32::NEG_INFINITY,
            |guide| guide.group_powers[0] = 2.0,
            |guide| guide.learned.truncate(3),
        ];
        for change in changes {
            let mut guide = guide(2.0, 1.0, "7:0..64");
            change(&mut guide);
            assert!(!guide.are_sound());
        }
    }
}
