//! Measured materials as the kernels read them (`glsl/include/bsdf/measured.glsl`): the words of their tables, their albedo, and a roughness
//! that says how broad they are.

use std::borrow::Cow;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3, dvec2};
use rayon::prelude::*;

use super::materials::scalar_mut;
use crate::generated::constants::{
    MEASURED_GRID_WORDS, MEASURED_GRIDS, MEASURED_HEAD_WORDS, MEASURED_ROUGHNESS, MEASURED_TABLE_HIGH,
    MEASURED_TABLE_LOW,
};
use crate::generated::layout::MaterialRecord;
use crate::scene::Scene;
use crate::scene::bsdf::{Bsdf, MaterialKind};
use crate::scene::measured::{Grids, Measured};

/// Samples along each side of the square over which means are taken.
const SAMPLES: usize = 16;
/// Most directions of the viewer over which the albedo is a mean.
const MOST_DIRECTIONS: usize = 64;

/// Completes the records of measured materials, and appends the words of their tables to grids. Returns each such material with the number
/// of its grid, which [`set_addresses`] takes.
pub(super) fn complete(
    scene: &Scene,
    records: &mut [MaterialRecord],
    grids: &mut Vec<Cow<[u32]>>,
) -> Vec<(usize, usize)> {
    let (mut known, mut found) = (HashMap::new(), Vec::new());
    for (at, material) in scene.materials.iter().enumerate() {
        let MaterialKind::Surface(surface) = &material.kind else { continue };
        let Bsdf::Measured(measured) = &surface.bsdf else { continue };
        let (grid, mean) = *known.entry(Arc::as_ptr(&measured.tables)).or_insert_with(|| {
            grids.push(Cow::Owned(words(&measured.tables)));
            (grids.len() - 1, mean(&measured.tables))
        });
        records[at].colors[0] = mean.albedo.extend(0.0).into();
        *scalar_mut(&mut records[at], MEASURED_ROUGHNESS) = mean.roughness;
        found.push((at, grid));
    }
    found
}

/// Writes the addresses of tables, in two parts that are exact as floats.
pub(super) fn set_addresses(records: &mut [MaterialRecord], found: &[(usize, usize)], addresses: &[u32]) {
    for &(at, grid) in found {
        let [high, low] = halves(addresses[grid]);
        *scalar_mut(&mut records[at], MEASURED_TABLE_HIGH) = high;
        *scalar_mut(&mut records[at], MEASURED_TABLE_LOW) = low;
    }
}

/// Upper and lower half of an address.
pub fn halves(address: u32) -> [f32; 2] {
    [(address >> 16) as f32, (address & 0xffff) as f32]
}

/// Words of the tables.
pub fn words(measured: &Measured) -> Vec<u32> {
    let Measured { phi, theta, ndf, sigma, vndf, luminance, colors: [red, green, blue] } = measured;
    let directions = phi.len() * theta.len();
    let plain = [red, green, blue, ndf, sigma].map(|grids| (grids, Cow::Borrowed(&grids.values[..])));
    let sampled = [luminance, vndf].map(|grids| {
        let all: Vec<_> =
            grids.values.par_chunks(grids.area()).map(|grid| Distribution::new(grid, grids.size)).collect();
        let numbers = all.into_iter().flat_map(|one| [one.density, one.columns, one.rows].concat());
        (grids, Cow::Owned(numbers.map(|number| number as f32).collect::<Vec<_>>()))
    });
    let all: Vec<_> = plain.into_iter().chain(sampled).collect();
    let head = MEASURED_HEAD_WORDS + MEASURED_GRIDS * MEASURED_GRID_WORDS;
    let mut place = head as usize + phi.len() + theta.len();
    let mut words = vec![phi.len() as u32, theta.len() as u32, measured.parts()];
    for (grids, numbers) in &all {
        let is_of_directions = grids.values.len() > grids.area() || directions == 1;
        let stride = if is_of_directions { numbers.len() / directions } else { 0 };
        words.extend([grids.size[0] as u32, grids.size[1] as u32, stride as u32, place as u32]);
        place += numbers.len();
    }
    words.extend(phi.iter().chain(theta).map(|angle| angle.to_bits()));
    words.extend(all.iter().flat_map(|(_, numbers)| numbers.iter().map(|number| number.to_bits())));
    words
}

/// Bilinear density over the unit square.
#[derive(Debug, Clone)]
struct Distribution {
    size: [usize; 2],
    /// Density at the points of the grid.
    density: Vec<f64>,
    /// Integral of the density along each row up to each of its points.
    columns: Vec<f64>,
    /// Integral of the density over all rows up to each row.
    rows: Vec<f64>,
}

impl Distribution {
    /// Density in proportion to the numbers of a grid; a constant one where all are 0.
    fn new(grid: &[f32], size: [usize; 2]) -> Self {
        let [width, height] = size;
        let steps = [width, height].map(|side| 1.0 / (side - 1) as f64);
        let mut density: Vec<_> = grid.iter().map(|&number| f64::from(number)).collect();
        if density.iter().all(|&number| number == 0.0) {
            density.fill(1.0);
        }
        let mut columns: Vec<f64> = density.chunks_exact(width).flat_map(|row| integral(row, steps[0])).collect();
        let totals: Vec<f64> = columns.chunks_exact(width).map(|row| row[width - 1]).collect();
        let mut rows = integral(&totals, steps[1]);
        let scale = 1.0 / rows[height - 1];
        [&mut density, &mut columns, &mut rows].into_iter().flatten().for_each(|number| *number *= scale);
        Self { size, density, columns, rows }
    }

    /// Point with the shares `u` of the density before it, and the density there.
    fn sample(&self, u: DVec2) -> (DVec2, f64) {
        let [width, height] = self.size;
        let row = self.rows.partition_point(|&before| before <= u.y).clamp(1, height - 1) - 1;
        let [first, second] = [row, row + 1].map(|row| row * width..(row + 1) * width);
        let totals = [&first, &second].map(|row| self.columns[row.end - 1]);
        let y = fraction((u.y - self.rows[row]) * (height - 1) as f64, totals);
        let mean =
            |table: &[f64], column: usize| (1.0 - y) * table[first.start + column] + y * table[second.start + column];
        let x = u.x * ((1.0 - y) * totals[0] + y * totals[1]);
        let column = (1..width - 1).take_while(|&column| mean(&self.columns, column) <= x).count();
        let ends = [column, column + 1].map(|column| mean(&self.density, column));
        let x = fraction((x - mean(&self.columns, column)) * (width - 1) as f64, ends);
        let point = dvec2((column as f64 + x) / (width - 1) as f64, (row as f64 + y) / (height - 1) as f64);
        (point, (1.0 - x) * ends[0] + x * ends[1])
    }
}

/// Integral of a piecewise linear function up to each of its points.
fn integral(values: &[f64], step: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let rest = values.windows(2).map(|pair| {
        sum += 0.5 * step * (pair[0] + pair[1]);
        sum
    });
    let mut all = vec![0.0];
    all.extend(rest);
    all
}

/// Place in [0, 1] up to which a line from the first to the second height covers this area.
fn fraction(area: f64, [first, second]: [f64; 2]) -> f64 {
    let root = (first * first + 2.0 * area * (second - first)).max(0.0).sqrt();
    (2.0 * area / (first + root).max(1.0e-30)).clamp(0.0, 1.0)
}

/// Number of a grid at a point of the unit square.
fn bilinear(grid: &[f32], [width, height]: [usize; 2], u: DVec2) -> f64 {
    let position = u.clamp(DVec2::ZERO, DVec2::ONE) * dvec2((width - 1) as f64, (height - 1) as f64);
    let [column, row] = [(position.x as usize).min(width - 2), (position.y as usize).min(height - 2)];
    let share = position - dvec2(column as f64, row as f64);
    let along = |row: usize| {
        let [first, second] = [0, 1].map(|more| f64::from(grid[row * width + column + more]));
        first + share.x * (second - first)
    };
    along(row) + share.y * (along(row + 1) - along(row))
}

/// Means over directions.
#[derive(Debug, Clone, Copy)]
pub struct Mean {
    /// Share of light that is reflected.
    pub albedo: Vec3,
    /// Roughness of facets of which half lie within the same angle about the normal, seen from above: the tangent of that angle, as it is for
    /// GGX.
    pub roughness: f32,
}

/// Samples of the facets that are seen from one direction: the angle with the normal, the brightness, and the color times the density of
/// the light's directions.
fn samples(measured: &Measured, azimuth: usize, elevation: usize) -> Vec<(f64, f64, DVec3)> {
    let Measured { phi, theta, ndf, sigma, vndf, luminance, colors } = measured;
    let turn = if measured.is_isotropic() { 0.0 } else { f64::from(phi[azimuth]) };
    let angle = f64::from(theta[elevation]);
    let wo = direction(angle, turn);
    let at = azimuth * theta.len() + elevation;
    let of = |grids: &Grids| {
        let grid = grids.values[at * grids.area()..][..grids.area()].to_vec();
        (grid, grids.size)
    };
    let visible = Distribution::new(&of(vndf).0, vndf.size);
    let [brightness, red, green, blue] = [luminance, &colors[0], &colors[1], &colors[2]].map(of);
    let seen = dvec2((angle / FRAC_PI_2).sqrt(), if measured.is_isotropic() { 0.5 } else { (turn + PI) / (2.0 * PI) });
    let area = bilinear(&sigma.values, sigma.size, seen);
    let one = |index: usize| {
        let s = dvec2((index % SAMPLES) as f64 + 0.5, (index / SAMPLES) as f64 + 0.5) / SAMPLES as f64;
        let (u, density) = visible.sample(s);
        let inclination = FRAC_PI_2 * u.x * u.x;
        let m = direction(inclination, (2.0 * u.y - 1.0) * PI);
        let wi = 2.0 * m.dot(wo) * m - wo;
        let jacobian = 2.0 * PI * PI * u.x * inclination.sin() * 4.0 * m.dot(wo);
        let number = |(grid, size): &(Vec<f32>, [usize; 2])| bilinear(grid, *size, s);
        let factor = bilinear(&ndf.values, ndf.size, u) / (4.0 * area).max(1.0e-20) * jacobian / density.max(1.0e-20);
        let is_above = wi.z > 0.0 && factor.is_finite();
        let color = DVec3::new(number(&red), number(&green), number(&blue));
        (inclination, number(&brightness), if is_above { color * factor } else { DVec3::ZERO })
    };
    (0..SAMPLES * SAMPLES).map(one).collect()
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Means over the directions of the viewer, and over the facets.
pub fn mean(measured: &Measured) -> Mean {
    let (azimuths, elevations) = (measured.phi.len(), measured.theta.len());
    let step = (azimuths * elevations).div_ceil(MOST_DIRECTIONS);
    let (mut albedo, mut total) = (DVec3::ZERO, 0.0);
    for at in (0..azimuths * elevations).step_by(step) {
        let elevation = at % elevations;
        let weight = (2.0 * f64::from(measured.theta[elevation])).sin().max(1.0e-3);
        let samples = samples(measured, at / elevations, elevation);
        albedo += weight * samples.iter().map(|(_, _, color)| *color).sum::<DVec3>() / samples.len() as f64;
        total += weight;
    }
    let mut seen: Vec<_> =
        samples(measured, 0, 0).into_iter().map(|(angle, brightness, _)| (angle, brightness)).collect();
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * seen.iter().map(|(_, brightness)| brightness).sum::<f64>();
    let mut sum = 0.0;
    let median = seen.iter().find(|(_, brightness)| {
        sum += brightness;
        sum >= half
    });
    let roughness = median.map_or(1.0, |(angle, _)| angle.tan().clamp(0.0, 1.0e3));
    Mean { albedo: (albedo / total).as_vec3().min(Vec3::ONE), roughness: roughness as f32 }
}
