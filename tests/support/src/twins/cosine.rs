//! Clamped cosines over parts of the sphere, by brute force. They are independent of the tables that the renderer
//! uploads.

use glam::DVec3;
use lodestar::math::direction_map::bin_center;
use lodestar::settings::DirectionMap;

/// Fine map of the sphere. Every point stands for the same solid angle.
pub struct SphereGrid {
    resolution: u32,
    directions: Vec<DVec3>,
}

impl SphereGrid {
    /// Map with `resolution` points along each side.
    pub fn new(map: DirectionMap, resolution: u32) -> Self {
        let directions = (0..resolution * resolution).map(|bin| bin_center(map, bin, resolution)).collect();
        Self { resolution, directions }
    }

    /// Integrals of `f` over each bin of a coarser map, whose bins this map subdivides.
    pub fn integrals(&self, coarse: u32, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        assert!(self.resolution.is_multiple_of(coarse), "{coarse} does not divide {}", self.resolution);
        let side = self.resolution / coarse;
        let mut sums = vec![0.0; (coarse * coarse) as usize];
        for (row, directions) in (0..).zip(self.directions.chunks(self.resolution as usize)) {
            for (column, &w) in (0..).zip(directions) {
                sums[(row / side * coarse + column / side) as usize] += f(w);
            }
        }
        let solid_angle = 4.0 * std::f64::consts::PI / f64::from(self.resolution).powi(2);
        sums.iter().map(|sum| sum * solid_angle).collect()
    }

    /// Directions of all points, row by row.
    pub fn directions(&self) -> &[DVec3] {
        &self.directions
    }

    /// Integrals of the clamped cosine about `n`.
    pub fn cosine_integrals(&self, coarse: u32, n: DVec3) -> Vec<f64> {
        self.integrals(coarse, |w| w.dot(n).max(0.0))
    }

    /// Solid angles above the horizon of `n`. Points on the horizon count half, because a row of the map may lie along
    /// it.
    pub fn visible(&self, coarse: u32, n: DVec3) -> Vec<f64> {
        self.integrals(coarse, |w| match w.dot(n) {
            cosine if cosine.abs() < 1.0e-9 => 0.5,
            cosine if cosine > 0.0 => 1.0,
            _ => 0.0,
        })
    }
}
