//! What a guide has learned at a point, as the page shows it.

use glam::{IVec3, Vec3};
use serde::Serialize;

use crate::encode::cells::Cells;
use crate::math::direction_map::{bin_center, bin_point};
use crate::settings::{DirectionMap, Settings};

/// Most bytes of a guide that is copied for viewers.
pub(super) const MOST_BYTES: u64 = 64 << 20;
/// Points along each side of a bin at which the cosine is looked up.
const LOOKUPS: u32 = 4;

/// Cells of a guide and the order of their bins. They stay the same during a render.
pub(super) struct GuideCells {
    pub cells: Cells,
    map: DirectionMap,
    /// Number of bins along each side of a map.
    side: u32,
}

/// Copy of what a guide has learned.
pub(super) struct GuideCopy {
    /// Number of the copy, counted from 1.
    pub number: u64,
    /// Samples per pixel that it was learned from.
    pub samples: u64,
    /// Radiance by cell and bin.
    pub radiance: Vec<f32>,
    /// Shares of the samples that cells leave to BSDFs; empty where they are fixed.
    pub shares: Vec<[f32; 2]>,
}

/// What a guide has learned about a point of a surface.
#[derive(Debug, Serialize)]
pub(super) struct Learned {
    /// Samples per pixel that it was learned from.
    pub samples: u64,
    pub cell: CellMap,
    /// Share of the samples that the cell leaves to diffuse lobes.
    pub bsdf_share: Option<f32>,
    /// Cells that share a face with the cell, each with the side on which it lies, such as `+x`.
    pub neighbors: Vec<(&'static str, CellMap)>,
    /// Number of bins along each side of a map.
    pub side: u32,
    /// Unit direction of every bin's center.
    pub directions: Vec<[f32; 3]>,
    /// Whether every bin's center lies above the surface.
    pub above: Vec<bool>,
    /// Direction in which the most radiance arrives, of those above the surface.
    pub brightest: [f32; 3],
    pub brightest_radiance: f32,
}

/// One cell and its map.
#[derive(Debug, Serialize)]
pub(super) struct CellMap {
    pub number: usize,
    /// Corners, world space.
    pub lower: [f32; 3],
    pub upper: [f32; 3],
    /// Radiance of every bin, row by row.
    pub radiance: Vec<f32>,
    /// Irradiance of a surface with the point's normal.
    pub irradiance: f64,
}

/// Sides on which neighbors lie.
const SIDES: [(&str, IVec3); 6] = [
    ("-x", IVec3::NEG_X),
    ("+x", IVec3::X),
    ("-y", IVec3::NEG_Y),
    ("+y", IVec3::Y),
    ("-z", IVec3::NEG_Z),
    ("+z", IVec3::Z),
];

impl GuideCells {
    pub fn new(cells: &Cells, settings: &Settings) -> Self {
        Self { cells: cells.clone(), map: settings.map, side: settings.directions }
    }

    /// Bytes of a copy.
    pub fn bytes(&self) -> u64 {
        u64::from(self.cells.count()) * self.bins() as u64 * size_of::<f32>() as u64
    }

    fn bins(&self) -> usize {
        self.side.pow(2) as usize
    }

    /// What `copy` knows about a surface at `position` with the unit normal `normal`.
    pub fn learned(&self, copy: &GuideCopy, position: Vec3, normal: Vec3) -> Learned {
        let place = self.cells.place_of(position);
        let cell = self.cells.cell_of(position);
        let weights = self.cosine_weights(normal);
        let map = |number: usize, place| self.cell_map(copy, number, place, &weights);
        let neighbor = |(side, step): (&'static str, IVec3)| {
            let place = (place.as_ivec3() + step).as_uvec3();
            Some((side, map(self.cells.cell_in(place)?, place)))
        };
        let directions: Vec<Vec3> = (0..self.bins() as u32).map(|bin| self.center(bin)).collect();
        let above: Vec<bool> = directions.iter().map(|direction| direction.dot(normal) > 0.0).collect();
        let cell_map = map(cell, place);
        let brightest = (0..self.bins())
            .filter(|&bin| above[bin])
            .max_by(|&a, &b| cell_map.radiance[a].total_cmp(&cell_map.radiance[b]))
            .unwrap_or(0);
        Learned {
            samples: copy.samples,
            bsdf_share: copy.shares.get(cell).map(|shares| shares[0]),
            neighbors: SIDES.into_iter().filter_map(neighbor).collect(),
            side: self.side,
            brightest: directions[brightest].into(),
            brightest_radiance: cell_map.radiance[brightest],
            directions: directions.into_iter().map(Into::into).collect(),
            above,
            cell: cell_map,
        }
    }

    fn cell_map(&self, copy: &GuideCopy, number: usize, place: glam::UVec3, weights: &[f64]) -> CellMap {
        let (lower, upper) = self.cells.grid.place_bounds(place);
        let radiance: Vec<f32> = copy.radiance.iter().skip(number * self.bins()).take(self.bins()).copied().collect();
        let irradiance = radiance.iter().zip(weights).map(|(&radiance, weight)| f64::from(radiance) * weight).sum();
        CellMap { number, lower: lower.into(), upper: upper.into(), radiance, irradiance }
    }

    fn center(&self, bin: u32) -> Vec3 {
        bin_center(self.map, bin, self.side).as_vec3()
    }

    /// Integral over every bin of the cosine to `normal`, where it is positive.
    fn cosine_weights(&self, normal: Vec3) -> Vec<f64> {
        let solid_angle = 4.0 * std::f64::consts::PI / self.bins() as f64;
        let weight = |bin: u32| {
            let cosines = (0..LOOKUPS * LOOKUPS).map(|i| {
                let within = (glam::dvec2(f64::from(i % LOOKUPS), f64::from(i / LOOKUPS)) + 0.5) / f64::from(LOOKUPS);
                bin_point(self.map, bin, self.side, within).dot(normal.as_dvec3()).max(0.0)
            });
            cosines.sum::<f64>() / f64::from(LOOKUPS * LOOKUPS) * solid_angle
        };
        (0..self.bins() as u32).map(weight).collect()
    }

    /// Mean radiance of a cell over all directions.
    pub fn mean(&self, copy: &GuideCopy, cell: usize) -> f32 {
        let bins = copy.radiance.iter().skip(cell * self.bins()).take(self.bins());
        bins.sum::<f32>() / self.bins() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::bvh::Bvh;
    use crate::scene::{FilmDescription, IntegratorDescription, ReconstructionFilter};
    use glam::UVec3;

    fn cells(map: DirectionMap) -> GuideCells {
        let bvh = Bvh::build(&[]);
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        let settings = Settings::for_film(&film, &IntegratorDescription::default());
        let settings = Settings { directions: 8, map, ..settings };
        GuideCells::new(&Cells::new(&bvh, &[], UVec3::ONE), &settings)
    }

    /// The irradiance under a sky of radiance 2 is 2 pi, whichever way a surface faces.
    #[test]
    fn irradiance_of_a_uniform_sky_is_known() {
        for map in [DirectionMap::EqualArea, DirectionMap::Cylindrical] {
            let cells = cells(map);
            let copy = GuideCopy { number: 1, samples: 8, radiance: vec![2.0; 64], shares: Vec::new() };
            for normal in [Vec3::Z, Vec3::NEG_Y, Vec3::new(1.0, -2.0, 0.5).normalize()] {
                let learned = cells.learned(&copy, Vec3::splat(0.5), normal);
                let expected = 2.0 * std::f64::consts::PI;
                assert!((learned.cell.irradiance / expected - 1.0).abs() < 0.02, "{}", learned.cell.irradiance);
                let above = learned.above.iter().filter(|&&above| above).count();
                assert!((24..=40).contains(&above), "{above} of 64 bins are above the surface");
            }
        }
    }

    #[test]
    fn the_brightest_bin_lies_above_the_surface() {
        let cells = cells(DirectionMap::EqualArea);
        let toward = |direction: Vec3| {
            let bins = (0..64).map(|bin| cells.center(bin).dot(direction).max(0.0).powi(20)).collect();
            GuideCopy { number: 1, samples: 8, radiance: bins, shares: Vec::new() }
        };
        let tilted = Vec3::new(0.6, 0.0, 0.8);
        let seen = cells.learned(&toward(tilted), Vec3::ZERO, Vec3::Z);
        assert!(Vec3::from(seen.brightest).dot(tilted) > 0.95, "{:?}", seen.brightest);
        let hidden = cells.learned(&toward(-tilted), Vec3::ZERO, Vec3::Z);
        assert!(Vec3::from(hidden.brightest).z > 0.0, "{:?}", hidden.brightest);
    }
}
