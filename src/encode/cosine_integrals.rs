//! Integrals of the clamped cosine around every representative normal over every direction bin. The normalization grid
//! is filled from this table.

use glam::{DVec3, dvec2};
use rayon::prelude::*;

use crate::generated::layout::CosineIntegral;
use crate::math::direction_map::{bin_point, representative_normal};
use crate::settings::DirectionMap;

mod border;
mod symmetry;
use border::Border;
use symmetry::{Symmetry, symmetries};

/// Meshes along each side of a bin for the bound of the cosine. Pieces of the bin's border are as long as a mesh.
const MESHES: u32 = 24;

/// Direction bin, independent of any normal.
struct Bin {
    border: Border,
    /// Points of a grid over the bin, its border included.
    grid: Vec<DVec3>,
    /// Largest distance (as a chord) from a direction of the bin to the nearest point of the grid.
    reach: f64,
}

/// Table `[direction bin][normal bin]` for maps of `directions * directions` and `normals * normals` bins.
pub fn cosine_integrals(map: DirectionMap, directions: u32, normals: u32) -> Vec<CosineIntegral> {
    let representative: Vec<DVec3> = (0..normals * normals).map(|bin| representative_normal(bin, normals)).collect();
    let turned: Vec<(u32, Symmetry)> = least_images(map, directions, normals);
    // The row of a bin equals the row of its least mirror image, with the normals mirrored too.
    let mut least: Vec<u32> = turned.iter().map(|image| image.0).collect();
    least.sort_unstable();
    least.dedup();
    let rows: Vec<Vec<CosineIntegral>> = least
        .par_iter()
        .map(|&index| {
            let bin = Bin::new(map, index, directions);
            representative.iter().map(|&n| bin.cosine_integral(n)).collect()
        })
        .collect();
    let row_of = |index: &u32| &rows[least.partition_point(|other| other < index)];
    let entries = turned.iter().flat_map(|(image, symmetry)| {
        let row = row_of(image);
        (0..normals * normals).map(move |normal| row[symmetry.image(DirectionMap::EqualArea, normal, normals) as usize])
    });
    entries.collect()
}

/// Least image of each direction bin, and the symmetry of both maps that leads there.
fn least_images(map: DirectionMap, directions: u32, normals: u32) -> Vec<(u32, Symmetry)> {
    let symmetries = symmetries(map, directions, normals);
    let images = |bin: u32| symmetries.iter().map(move |&symmetry| (symmetry.image(map, bin, directions), symmetry));
    (0..directions * directions).filter_map(|bin| images(bin).min_by_key(|image| image.0)).collect()
}

impl Bin {
    fn new(map: DirectionMap, index: u32, directions: u32) -> Self {
        let grid: Vec<DVec3> = points(map, index, directions, MESHES);
        let row = MESHES as usize + 1;
        // Half the longest diagonal of the grid's meshes, doubled to allow for their curvature.
        let diagonal = |i: usize| (grid[i] - grid[i + row + 1]).length().max((grid[i + 1] - grid[i + row]).length());
        let meshes = (0..row - 1).flat_map(|y| (0..row - 1).map(move |x| y * row + x));
        let reach = meshes.map(diagonal).fold(0.0, f64::max);
        // Every piece of the border has a middle point, so twice the points are needed.
        let fine = points(map, index, directions, 2 * MESHES);
        let around: Vec<DVec3> = around(2 * MESHES as usize).map(|at| fine[at]).collect();
        Self { border: Border::new(&around), grid, reach }
    }

    fn cosine_integral(&self, n: DVec3) -> CosineIntegral {
        let most = self.grid.iter().map(|w| w.dot(n)).fold(-1.0, f64::max);
        // A cosine rises by at most the chord to the nearest point of the grid.
        let maximum = (most + self.reach).clamp(0.0, 1.0);
        let integral = if maximum > 0.0 { self.border.cosine_integral(n).max(0.0) } else { 0.0 };
        CosineIntegral { integral: integral as f32, maximum: maximum as f32 }
    }
}

/// Indices of the border of a grid of `meshes * meshes`, counterclockwise from its first corner, each once.
fn around(meshes: usize) -> impl Iterator<Item = usize> {
    let row = meshes + 1;
    let bottom = 0..meshes;
    let right = (0..meshes).map(move |y| y * row + meshes);
    let top = (1..row).rev().map(move |x| meshes * row + x);
    let left = (1..row).rev().map(move |y| y * row);
    bottom.chain(right).chain(top).chain(left)
}

/// Directions of a grid of `meshes * meshes` over a bin, its border included. Their distances are about equal all over
/// the bin.
fn points(map: DirectionMap, bin: u32, directions: u32, meshes: u32) -> Vec<DVec3> {
    let step = 1.0 / f64::from(meshes);
    let height = |y: u32| match map {
        DirectionMap::EqualArea => f64::from(y) * step,
        DirectionMap::Cylindrical => height_at_even_angle(bin / directions, directions, f64::from(y) * step),
    };
    let point = |x: u32, y: u32| bin_point(map, bin, directions, dvec2(f64::from(x) * step, height(y)));
    (0..=meshes).flat_map(|y| (0..=meshes).map(move |x| (x, y))).map(|(x, y)| point(x, y)).collect()
}

/// Height in [0, 1] within a row of the cylindrical map's bins at which the given share of the row's angle is reached.
fn height_at_even_angle(row: u32, directions: u32, share: f64) -> f64 {
    let height = |angle: f64| (0.5 * angle.sin() + 0.5) * f64::from(directions) - f64::from(row);
    let angle = |row: u32| (2.0 * f64::from(row) / f64::from(directions) - 1.0).asin();
    height(angle(row) + share * (angle(row + 1) - angle(row))).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    const MAPS: [DirectionMap; 2] = [DirectionMap::EqualArea, DirectionMap::Cylindrical];
    /// Sides of the maps of directions and of normals, even and odd.
    const SIZES: [(u32, u32); 3] = [(8, 6), (6, 5), (5, 4)];

    #[test]
    fn each_normal_sees_pi_in_all() {
        let normals = 16;
        for map in MAPS {
            let table = cosine_integrals(map, 16, normals);
            let count = (normals * normals) as usize;
            for normal in 0..count {
                let sum: f64 = table.iter().skip(normal).step_by(count).map(|c| f64::from(c.integral)).sum();
                // Each of 256 summands is rounded to single precision.
                assert!((sum / PI - 1.0).abs() < 2.0e-8, "{map:?}, normal bin {normal}: {sum}");
            }
        }
    }

    /// Integral over a bin of the cylindrical map for a normal in the equator, where azimuths and heights separate.
    fn closed_form(bin: u32, directions: u32, azimuth: f64) -> f64 {
        let edge = |i: u32| 2.0 * f64::from(i) / f64::from(directions) - 1.0;
        let planar = |z: f64| 0.5 * (z * (1.0 - z * z).max(0.0).sqrt() + z.asin());
        // Azimuth relative to the normal, within half a turn.
        let from_normal = |i: u32| {
            let middle = PI * (edge(bin % directions) + 1.0 / f64::from(directions)) - azimuth;
            PI * edge(i) - azimuth - (middle / (2.0 * PI)).round() * 2.0 * PI
        };
        let sine = |i: u32| from_normal(i).clamp(-FRAC_PI_2, FRAC_PI_2).sin();
        let (column, row) = (bin % directions, bin / directions);
        (sine(column + 1) - sine(column)) * (planar(edge(row + 1)) - planar(edge(row)))
    }

    #[test]
    fn integrals_are_those_in_closed_form() {
        let directions = 16;
        for azimuth in [0.03, 0.4, 1.9, -2.2, 3.1] {
            let n = DVec3::new(f64::cos(azimuth), f64::sin(azimuth), 0.0);
            for index in 0..directions * directions {
                let found = Bin::new(DirectionMap::Cylindrical, index, directions).border.cosine_integral(n);
                let expected = closed_form(index, directions, azimuth);
                assert!((found - expected).abs() < 1.0e-9, "bin {index}, {azimuth}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn rows_of_mirrored_bins_are_their_own() {
        for (map, (directions, normals)) in MAPS.into_iter().flat_map(|map| SIZES.map(|size| (map, size))) {
            let table = cosine_integrals(map, directions, normals);
            for (bin, row) in (0..).zip(table.chunks((normals * normals) as usize)) {
                let own = Bin::new(map, bin, directions);
                for (normal, entry) in (0..).zip(row) {
                    let expected = own.cosine_integral(representative_normal(normal, normals));
                    let error = (entry.integral - expected.integral).abs() + (entry.maximum - expected.maximum).abs();
                    assert!(error < 1.0e-5, "{map:?}, bin {bin}, normal {normal}: {entry:?} instead of {expected:?}");
                }
            }
        }
    }

    #[test]
    fn bounds_hold_and_are_tight() {
        let (directions, normals) = (16, 8);
        for map in MAPS {
            let table = cosine_integrals(map, directions, normals);
            for bin in 0..directions * directions {
                for normal in 0..normals * normals {
                    let n = representative_normal(normal, normals);
                    let within = points(map, bin, directions, 41);
                    let truth = within.iter().map(|w| w.dot(n)).fold(-1.0, f64::max);
                    let bound = f64::from(table[(bin * normals * normals + normal) as usize].maximum);
                    assert!(bound >= truth - 1e-7, "{map:?}: {bound} < {truth}");
                    assert!(bound <= truth.max(0.0) + 0.03, "{map:?}: {bound} is far above {truth}");
                }
            }
        }
    }
}
