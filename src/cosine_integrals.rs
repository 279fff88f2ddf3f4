//! What the clamped cosine of every representative normal amounts to over every direction bin: the table from which the
//! normalization grid is filled.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, dvec2, dvec3};
use rayon::prelude::*;

use crate::layout::CosineIntegral;
use crate::reference::direction_map::{bin_point, representative_normal};
use crate::settings::DirectionMap;

mod symmetry;
use symmetry::{Symmetry, symmetries};

/// Points along each side of the whole map, for the integrals of directions; those over a hemisphere come out within 1e-5.
const SAMPLES: u32 = 512;
/// The same in bins that the horizon cuts, where the integrand has a kink.
const HORIZON_SAMPLES: u32 = 2048;
/// Meshes along each side of a bin, for the bound of the cosine.
const MESHES: u32 = 24;

/// One direction bin, independent of any normal.
struct Bin {
    /// Integral of the direction over the bin, sr.
    vector: DVec3,
    /// Points of a grid over the bin, its border included.
    grid: Vec<DVec3>,
    /// No direction of the bin is farther than this from some point of the grid, as a chord.
    reach: f64,
    /// The points that stand for the bin where the horizon cuts it.
    fine: Vec<DVec3>,
}

/// Entries `[direction bin][normal bin]` for maps of the given resolutions.
pub fn cosine_integrals(map: DirectionMap, directions: u32, normals: u32) -> Vec<CosineIntegral> {
    let representative: Vec<DVec3> = (0..normals * normals).map(|bin| representative_normal(bin, normals)).collect();
    let turned: Vec<(u32, Symmetry)> = least_images(map, directions, normals);
    // A bin's row is that of the least of its mirror images, with the normals mirrored too.
    let mut least: Vec<u32> = turned.iter().map(|image| image.0).collect();
    least.sort_unstable();
    least.dedup();
    let rows: Vec<Vec<CosineIntegral>> = least
        .par_iter()
        .map(|&index| {
            let bin = Bin::new(map, index, directions);
            representative.iter().map(|&n| bin.cosine_integral(directions, n)).collect()
        })
        .collect();
    let row_of = |index: &u32| &rows[least.partition_point(|other| other < index)];
    let entries = turned.iter().flat_map(|(image, symmetry)| {
        let row = row_of(image);
        (0..normals * normals).map(move |normal| row[symmetry.image(DirectionMap::EqualArea, normal, normals) as usize])
    });
    entries.collect()
}

/// For each direction bin the least of its images, and the symmetry of both maps that leads there.
fn least_images(map: DirectionMap, directions: u32, normals: u32) -> Vec<(u32, Symmetry)> {
    let symmetries = symmetries(map, directions, normals);
    let images = |bin: u32| symmetries.iter().map(move |&symmetry| (symmetry.image(map, bin, directions), symmetry));
    (0..directions * directions).filter_map(|bin| images(bin).min_by_key(|image| image.0)).collect()
}

impl Bin {
    fn new(map: DirectionMap, index: u32, directions: u32) -> Self {
        let vector = match map {
            DirectionMap::EqualArea => direction_by_points(index, directions),
            DirectionMap::Cylindrical => direction_over_cylinder(index, directions),
        };
        let grid: Vec<DVec3> =
            border_grid(map, index, directions).map(|p| bin_point(map, index, directions, p)).collect();
        let row = MESHES as usize + 1;
        // Half the longest diagonal of the grid's meshes, twice over for their curvature.
        let diagonal = |i: usize| (grid[i] - grid[i + row + 1]).length().max((grid[i + 1] - grid[i + row]).length());
        let meshes = (0..row - 1).flat_map(|y| (0..row - 1).map(move |x| y * row + x));
        let reach = meshes.map(diagonal).fold(0.0, f64::max);
        let fine = points(HORIZON_SAMPLES.div_ceil(directions)).map(|p| bin_point(map, index, directions, p)).collect();
        Self { vector, grid, reach, fine }
    }

    fn cosine_integral(&self, directions: u32, n: DVec3) -> CosineIntegral {
        let cosines = self.grid.iter().map(|w| w.dot(n));
        let (least, most) = cosines.fold((1.0, -1.0), |(least, most): (f64, f64), c| (least.min(c), most.max(c)));
        let integral = if least >= self.reach {
            n.dot(self.vector)
        } else if most <= -self.reach {
            0.0
        } else {
            let above = self.fine.iter().map(|w| w.dot(n).max(0.0)).sum::<f64>();
            above * solid_angle(directions, HORIZON_SAMPLES.div_ceil(directions))
        };
        // A cosine cannot rise by more than the chord to the nearest point of the grid.
        CosineIntegral { integral: integral as f32, maximum: (most + self.reach).clamp(0.0, 1.0) as f32 }
    }
}

/// Solid angle of one of `side * side` equal parts of a bin.
fn solid_angle(directions: u32, side: u32) -> f64 {
    4.0 * std::f64::consts::PI / f64::from(directions * side).powi(2)
}

/// The centers of `side * side` equal squares in [0, 1]^2.
fn points(side: u32) -> impl Iterator<Item = DVec2> {
    let step = 1.0 / f64::from(side);
    (0..side * side).map(move |i| dvec2((f64::from(i % side) + 0.5) * step, (f64::from(i / side) + 0.5) * step))
}

/// Integral of the direction over a bin of the equal-area square.
fn direction_by_points(bin: u32, directions: u32) -> DVec3 {
    let samples = SAMPLES.div_ceil(directions);
    let sum: DVec3 = points(samples).map(|p| bin_point(DirectionMap::EqualArea, bin, directions, p)).sum();
    sum * solid_angle(directions, samples)
}

/// The same over a bin of the cylindrical map, in closed form: it is not smooth at the poles.
fn direction_over_cylinder(bin: u32, directions: u32) -> DVec3 {
    let edge = |i: u32| 2.0 * f64::from(i) / f64::from(directions) - 1.0;
    let (column, row) = (bin % directions, bin / directions);
    let (phi0, phi1) = (PI * edge(column), PI * edge(column + 1));
    let (z0, z1) = (edge(row), edge(row + 1));
    let planar = |z: f64| 0.5 * (z * (1.0 - z * z).max(0.0).sqrt() + z.asin());
    let radial = planar(z1) - planar(z0);
    let axial = 0.5 * (z1 * z1 - z0 * z0) * (phi1 - phi0);
    dvec3(radial * (phi1.sin() - phi0.sin()), radial * (phi0.cos() - phi1.cos()), axial)
}

/// A grid over [0, 1]^2 that includes its border; its directions are about as far from each other all over the bin.
fn border_grid(map: DirectionMap, bin: u32, directions: u32) -> impl Iterator<Item = DVec2> {
    let step = 1.0 / f64::from(MESHES);
    let height = move |y: u32| match map {
        DirectionMap::EqualArea => f64::from(y) * step,
        DirectionMap::Cylindrical => height_at_even_angle(bin / directions, directions, f64::from(y) * step),
    };
    (0..=MESHES).flat_map(move |y| (0..=MESHES).map(move |x| dvec2(f64::from(x) * step, height(y))))
}

/// Where in [0, 1] of a row of the cylindrical map's bins this share of its angle lies.
fn height_at_even_angle(row: u32, directions: u32, share: f64) -> f64 {
    let height = |angle: f64| (0.5 * angle.sin() + 0.5) * f64::from(directions) - f64::from(row);
    let angle = |row: u32| (2.0 * f64::from(row) / f64::from(directions) - 1.0).asin();
    height(angle(row) + share * (angle(row + 1) - angle(row))).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
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
                assert!((sum / PI - 1.0).abs() < 1e-5, "{map:?}, normal bin {normal}: {sum}");
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
                    let expected = own.cosine_integral(directions, representative_normal(normal, normals));
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
                    let within = points(41).chain(border_grid(map, bin, directions));
                    let truth = within.map(|p| bin_point(map, bin, directions, p).dot(n)).fold(-1.0, f64::max);
                    let bound = f64::from(table[(bin * normals * normals + normal) as usize].maximum);
                    assert!(bound >= truth - 1e-7, "{map:?}: {bound} < {truth}");
                    assert!(bound <= truth.max(0.0) + 0.03, "{map:?}: {bound} is far above {truth}");
                }
            }
        }
    }
}
