//! Cells of a guide: the places of a regular grid over the scene that hold surfaces or media, and their parents. A parent joins
//! up to 2 x 2 x 2 cells, which borrow from it while they have learned little. CPU only.

mod grid;
mod occupancy;

use std::ops::Range;

use glam::{UVec3, Vec3};

use crate::encode::bvh::Bvh;
use crate::generated::constants;
use grid::extent;
use occupancy::occupied_places;

pub use grid::Grid;

/// Numbers of places that are tried along the longest side of the scene.
const LONGEST_SIDES: [u32; 19] = [4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 21, 24, 28, 32, 38, 44, 52, 64];

/// Cells of a scene, level by level: first the cells that hold surfaces or media, then their parents, and so on to the one cell
/// that is all of the scene. Within a level, Morton order (Morton 1966) keeps neighbors together.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Grid in which the cells lie.
    pub grid: Grid,
    /// Table that `glsl/include/guide/grid/cells.glsl` reads, in three parts. First, the cell of every place; a place
    /// without surfaces has the next cell. Second, the parent of every cell, `NONE` for the last. Third, the first
    /// child of every parent, and one end marker.
    pub table: Vec<u32>,
    /// Boxes that hold the scene's media, as (minimum, maximum).
    pub media: Vec<(Vec3, Vec3)>,
    /// Place of every cell that holds surfaces or media.
    places: Vec<UVec3>,
    levels: Vec<Range<u32>>,
    /// Morton keys of the places that hold surfaces, in the order of their cells.
    keys: Vec<u64>,
}

impl Cells {
    /// Cells of a grid of `size` places over a scene, whose media lie in these boxes.
    pub fn new(bvh: &Bvh, media: &[(Vec3, Vec3)], size: UVec3) -> Self {
        let grid = Grid::new(bvh, size);
        let mut is_occupied = occupied_places(bvh, &grid);
        for &(min, max) in media {
            let place = |corner| grid.clamped(grid.coordinates(corner));
            Grid::places(place(min), place(max)).for_each(|place| is_occupied[grid.index(place)] = true);
        }
        Self { media: media.to_vec(), ..Self::of_places(grid, &is_occupied) }
    }

    /// Finest cells that `fits` accepts, as near to cubes as the scene's box allows. Sizes grow in steps of about a
    /// sixth.
    pub fn fitting(bvh: &Bvh, media: &[(Vec3, Vec3)], fits: impl Fn(&Self) -> bool) -> Self {
        let extent = extent(bvh);
        let of_longest = |longest: u32| {
            let size = extent / extent.max_element() * longest as f32;
            Self::new(bvh, media, size.map(|places| (places - 0.01).ceil().max(1.0)).as_uvec3())
        };
        let mut untried = 0..LONGEST_SIDES.len();
        let mut finest = None;
        while !untried.is_empty() {
            let middle = usize::midpoint(untried.start, untried.end);
            let cells = of_longest(LONGEST_SIDES[middle]);
            if fits(&cells) {
                (untried.start, finest) = (middle + 1, Some(cells));
            } else {
                untried.end = middle;
            }
        }
        finest.unwrap_or_else(|| of_longest(LONGEST_SIDES[0]))
    }

    /// Cells of the places of a grid that [`Cells::occupancy`] has named.
    pub fn of_occupancy(grid: Grid, bits: &[u8]) -> Self {
        let is_occupied = |place: usize| bits.get(place / 8).is_some_and(|byte| byte >> (place % 8) & 1 == 1);
        Self::of_places(grid, &(0..grid.place_count()).map(is_occupied).collect::<Vec<_>>())
    }

    /// Places that have a cell of their own, a bit each, in the order of [`Grid::index`]. The lowest bit of a byte is the first.
    pub fn occupancy(&self) -> Vec<u8> {
        let mut bits = vec![0; self.grid.place_count().div_ceil(8)];
        for place in self.places.iter().map(|&place| self.grid.index(place)) {
            bits[place / 8] |= 1 << (place % 8);
        }
        bits
    }

    /// Whether both have the same cells in the same places.
    pub fn are_those_of(&self, other: &Self) -> bool {
        self.grid == other.grid && self.table == other.table
    }

    /// No cells, for renders that learn nothing.
    pub fn none(bvh: &Bvh) -> Self {
        let (table, media, places, levels, keys) = Default::default();
        Self { grid: Grid::new(bvh, UVec3::ONE), table, media, places, levels, keys }
    }

    fn of_places(grid: Grid, is_occupied: &[bool]) -> Self {
        let mut occupied: Vec<UVec3> =
            Grid::places(UVec3::ZERO, grid.size - 1).filter(|&place| is_occupied[grid.index(place)]).collect();
        if occupied.is_empty() {
            occupied.push(UVec3::ZERO);
        }
        occupied.sort_unstable_by_key(|&place| morton_key(place));
        let keys: Vec<u64> = occupied.iter().copied().map(morton_key).collect();
        let places = Grid::places(UVec3::ZERO, grid.size - 1).map(|place| cell_or_next(&keys, morton_key(place)));
        let mut table: Vec<u32> = places.collect();
        let (parents, first_children, levels) = ancestry(keys.clone());
        table.extend(parents);
        table.extend(first_children);
        Self { grid, table, media: Vec::new(), places: occupied, levels, keys }
    }

    /// Number of cells that hold surfaces.
    pub fn count(&self) -> u32 {
        self.levels.first().map_or(0, |level| level.end)
    }

    /// Number of all cells, parents included.
    pub fn all_count(&self) -> u32 {
        self.levels.last().map_or(0, |level| level.end)
    }

    /// Ranges of the parent cells, level by level, from the smallest cells to the largest.
    pub fn parent_levels(&self) -> &[Range<u32>] {
        self.levels.get(1..).unwrap_or_default()
    }

    /// Lower and upper corner of every cell that holds surfaces, world space.
    pub fn boxes(&self) -> Vec<[Vec3; 2]> {
        let corner = |place: UVec3| self.grid.origin + place.as_vec3() / self.grid.per_unit;
        self.places.iter().map(|&place| [corner(place), corner(place + UVec3::ONE)]).collect()
    }

    /// Cell of a point on a surface, as `grid_cell` of `glsl/include/guide/grid/cells.glsl` finds it.
    pub fn cell_of(&self, position: Vec3) -> usize {
        let place = self.grid.clamped(self.grid.coordinates(position));
        self.table.get(self.grid.index(place)).map_or(0, |&cell| cell as usize)
    }

    /// Place of a point; for a point outside the grid, the nearest place.
    pub fn place_of(&self, position: Vec3) -> UVec3 {
        self.grid.clamped(self.grid.coordinates(position))
    }

    /// Cell of a place that holds surfaces; `None` for a place without surfaces or outside the grid.
    pub fn cell_in(&self, place: UVec3) -> Option<usize> {
        let is_inside = place.cmplt(self.grid.size).all();
        is_inside.then(|| self.keys.binary_search(&morton_key(place)).ok()).flatten()
    }
}

/// Cell with the given key; without one, the next cell.
fn cell_or_next(keys: &[u64], key: u64) -> u32 {
    let (Ok(cell) | Err(cell)) = keys.binary_search(&key);
    cell.min(keys.len() - 1) as u32
}

/// Parent of every cell, first cell of every parent, and ranges of the levels. A parent's key is an eighth of its
/// children's keys, rounded down.
fn ancestry(mut keys: Vec<u64>) -> (Vec<u32>, Vec<u32>, Vec<Range<u32>>) {
    let (mut parents, mut first_children, mut levels) = (Vec::new(), Vec::new(), Vec::new());
    let mut first = 0;
    while keys.len() > 1 {
        let end = first + keys.len() as u32;
        levels.push(first..end);
        let mut of_parents: Vec<u64> = Vec::new();
        for (cell, key) in (first..).zip(&keys) {
            if of_parents.last() != Some(&(key >> 3)) {
                of_parents.push(key >> 3);
                first_children.push(cell);
            }
            parents.push(end + of_parents.len() as u32 - 1);
        }
        (keys, first) = (of_parents, end);
    }
    levels.push(first..first + 1);
    parents.push(constants::NONE);
    first_children.push(first);
    (parents, first_children, levels)
}

/// Morton key of a place: the bits of its three coordinates interleaved.
pub(super) fn morton_key(place: UVec3) -> u64 {
    let spread = |x: u32| (0..21).fold(0, |key, bit| key | u64::from(x >> bit & 1) << (3 * bit));
    spread(place.x) | spread(place.y) << 1 | spread(place.z) << 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::uvec3;

    fn grid(size: UVec3) -> Grid {
        Grid { origin: Vec3::ZERO, per_unit: Vec3::ONE, size }
    }

    /// Some places of a grid whose sides are no powers of two.
    fn some() -> (Grid, Vec<bool>, Cells) {
        let grid = grid(uvec3(5, 3, 6));
        let is_occupied: Vec<bool> = (0..grid.place_count()).map(|i| i * 7 % 11 < 4).collect();
        let cells = Cells::of_places(grid, &is_occupied);
        (grid, is_occupied, cells)
    }

    #[test]
    fn every_place_that_holds_a_surface_has_a_cell_of_its_own() {
        let (grid, is_occupied, cells) = some();
        let mut seen = vec![false; cells.count() as usize];
        for place in Grid::places(UVec3::ZERO, grid.size - 1) {
            let cell = cells.table[grid.index(place)] as usize;
            assert_eq!(cells.cell_of(place.as_vec3() + 0.5), cell);
            assert_eq!(cells.place_of(place.as_vec3() + 0.5), place);
            assert_eq!(cells.cell_in(place), is_occupied[grid.index(place)].then_some(cell));
            assert!(!is_occupied[grid.index(place)] || !std::mem::replace(&mut seen[cell], true));
        }
        assert!(seen.iter().all(|&seen| seen));
    }

    #[test]
    fn parents_hold_two_places_along_each_axis() {
        let (grid, is_occupied, cells) = some();
        let parents = &cells.table[grid.place_count()..][..cells.all_count() as usize];
        let first_children = &cells.table[grid.place_count() + cells.all_count() as usize..];
        let shared = |a: UVec3, b: UVec3| {
            if [a, b].iter().any(|&place| !is_occupied[grid.index(place)]) {
                return;
            }
            let mut pair = [a, b].map(|place| cells.table[grid.index(place)]);
            for level in 1..4_u32 {
                pair = pair.map(|cell| parents[cell as usize]);
                assert_eq!(pair[0] == pair[1], a >> level == b >> level, "{a} {b} {level}");
                assert!(pair.iter().all(|cell| cells.parent_levels()[level as usize - 1].contains(cell)));
            }
            assert_eq!(parents[pair[0] as usize], constants::NONE);
        };
        for a in Grid::places(UVec3::ZERO, grid.size - 1) {
            Grid::places(UVec3::ZERO, grid.size - 1).for_each(|b| shared(a, b));
        }
        for (parent, children) in (cells.count()..).zip(first_children.windows(2)) {
            assert!(children[0] < children[1] && children[1] - children[0] <= 8);
            assert!((children[0]..children[1]).all(|child| parents[child as usize] == parent));
        }
    }

    #[test]
    fn occupied_places_name_the_cells() {
        let (grid, _, cells) = some();
        assert_eq!(Cells::of_occupancy(grid, &cells.occupancy()), cells);
        assert!(cells.are_those_of(&Cells::of_occupancy(grid, &cells.occupancy())));
        let mut bits = cells.occupancy();
        bits[0] ^= 1;
        assert!(!cells.are_those_of(&Cells::of_occupancy(grid, &bits)));
        // Too few bits name no places.
        assert_eq!(Cells::of_occupancy(grid, &[]).count(), 1);
    }

    #[test]
    fn a_scene_without_surfaces_has_one_cell() {
        let cells = Cells::of_places(grid(UVec3::splat(4)), &[false; 64]);
        assert_eq!((cells.count(), cells.all_count(), cells.parent_levels().len()), (1, 1, 0));
        assert_eq!(cells.cell_of(Vec3::splat(9.0)), 0);
    }
}
