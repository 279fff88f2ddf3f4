//! Equal-area maps of the sphere to the square, by which pbrt-v4 stores environments (Clarberg 2008), and their conversion to
//! maps of longitude and latitude.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::rasters::Raster;

/// Largest width of a map of longitude and latitude that is made.
const MAX_WIDTH: usize = 4096;
/// Number of points along each side of a texel at which the square map is looked up.
const POINTS: usize = 4;

/// Place of a direction in the unit square: the inverse of [`square_to_sphere`](crate::math::equal_area::square_to_sphere).
pub(super) fn square_from_direction(direction: DVec3) -> DVec2 {
    let DVec3 { x, y, z } = direction.abs();
    let radius = (1.0 - z).max(0.0).sqrt();
    // The angle in quarter turns.
    let angle = if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) / FRAC_PI_2 };
    let mut at = DVec2::new(radius * (1.0 - angle), radius * angle);
    if direction.z < 0.0 {
        // The lower half of the sphere lies in the corners.
        at = DVec2::new(1.0 - at.y, 1.0 - at.x);
    }
    let signed = DVec2::new(at.x.copysign(direction.x), at.y.copysign(direction.y));
    0.5 * (signed + 1.0)
}

/// Map of longitude and latitude of a square map, whose `+z` becomes the map's `+y`. Each texel is the mean over its cell. The
/// map has the energy of the square map in each channel.
pub(super) fn unrolled(square: &Raster) -> Raster {
    let side = square.width;
    let mut map = rolled(2 * side, |direction| {
        let at = square_from_direction(direction) * side as f64;
        let index = |at: f64| (at as usize).min(side - 1);
        square.texels[index(at.y) * side + index(at.x)].as_dvec3()
    });
    let mean = |colors: &Raster| colors.texels.iter().map(|texel| texel.as_dvec3()).sum::<DVec3>();
    let (wanted, found) = (mean(square) / (side * side) as f64, sphere_mean(&map));
    let factor = DVec3::select(found.cmpgt(DVec3::ZERO), wanted / found, DVec3::ONE).as_vec3();
    map.texels.iter_mut().for_each(|texel| *texel *= factor);
    map
}

/// Map of longitude and latitude of a function of the direction, whose `+z` becomes the map's `+y`. Each texel is the mean over its cell.
/// `width` is the wanted number of texels in a row.
pub(super) fn rolled(width: usize, look_up: impl Fn(DVec3) -> DVec3 + Sync) -> Raster {
    let width = width.clamp(8, MAX_WIDTH);
    let height = width / 2 + 1;
    let azimuths: Vec<DVec2> = (0..width * POINTS)
        .map(|point| DVec2::from_angle((point as f64 + 0.5) / (width * POINTS) as f64 * TAU))
        .collect();
    let row = |row: usize| {
        // The first and the last row are the poles, so their cells are half as high.
        let edge = |at: f64| (at / (height - 1) as f64 * PI).clamp(0.0, PI);
        let (top, bottom) = (edge(row as f64 - 0.5), edge(row as f64 + 0.5));
        let polar = |point: usize| top + (point as f64 + 0.5) / POINTS as f64 * (bottom - top);
        let polars: Vec<_> = (0..POINTS).map(|point| polar(point).sin_cos()).collect();
        let weights: f64 = polars.iter().map(|(sine, _)| sine).sum::<f64>() * POINTS as f64;
        let texel = |column: usize| {
            let mut sum = DVec3::ZERO;
            for &(sine, cosine) in &polars {
                for azimuth in &azimuths[column * POINTS..(column + 1) * POINTS] {
                    // In the map's space, the azimuth runs from -z towards +x. There, (x, y, z) is (x, -z, y) of pbrt's.
                    sum += sine * look_up(DVec3::new(sine * azimuth.y, sine * azimuth.x, cosine));
                }
            }
            (sum / weights).as_vec3()
        };
        (0..width).map(texel).collect::<Vec<Vec3>>()
    };
    let texels: Vec<Vec3> = (0..height).into_par_iter().flat_map_iter(row).collect();
    Raster { width, height, texels }
}

/// Direction of a texel's center in the space of a map of longitude and latitude. The first and the last row are the poles.
pub(super) fn direction_of_texel(column: usize, row: usize, width: usize, height: usize) -> DVec3 {
    let (sine, cosine) = (row as f64 / (height - 1) as f64 * PI).sin_cos();
    let azimuth = DVec2::from_angle((column as f64 + 0.5) / width as f64 * TAU);
    DVec3::new(sine * azimuth.y, cosine, -sine * azimuth.x)
}

/// Mean radiance over the sphere of a map of longitude and latitude that is interpolated between the centers of its texels.
fn sphere_mean(map: &Raster) -> DVec3 {
    let step = PI / (map.height - 1) as f64;
    let mut mean = DVec3::ZERO;
    for (row, texels) in map.texels.chunks_exact(map.width).enumerate() {
        // Integral of the sine times the hat of the row.
        let polar = row as f64 * step;
        let weight = match row == 0 || row + 1 == map.height {
            true => 1.0 - step.sin() / step,
            false => polar.sin() * 2.0 * (1.0 - step.cos()) / step,
        };
        let sum: DVec3 = texels.iter().map(|texel| texel.as_dvec3()).sum();
        mean += 0.5 * weight / map.width as f64 * sum;
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::equal_area::square_to_sphere;

    fn direction_from_square(at: DVec2) -> DVec3 {
        square_to_sphere(2.0 * at - 1.0)
    }

    fn points() -> impl Iterator<Item = DVec2> {
        (0..64).flat_map(|y| (0..64).map(move |x| (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / 64.0))
    }

    #[test]
    fn places_come_back() {
        for at in points() {
            let direction = direction_from_square(at);
            assert!((direction.length() - 1.0).abs() < 1e-12);
            let back = square_from_direction(direction);
            assert!((back - at).length() < 1e-9, "{at} became {back}");
        }
    }

    /// Each function of the direction keeps its mean and its place. A map that is mirrored or turned fails.
    #[test]
    fn maps_keep_their_light() {
        let function = |d: DVec3| Vec3::new(1.0 + d.x as f32, 1.0 + 0.5 * (d.y + d.z) as f32, (d.z * d.z) as f32);
        let texels = points().map(|at| function(direction_from_square(at))).collect();
        let map = unrolled(&Raster { width: 64, height: 64, texels });
        assert!((sphere_mean(&map) - DVec3::new(1.0, 1.0, 1.0 / 3.0)).length() < 2e-3, "{}", sphere_mean(&map));
        for (index, texel) in map.texels.iter().enumerate() {
            let (column, row) = (index % map.width, index / map.width);
            // The direction in the map's space, and then in pbrt's.
            let d = direction_of_texel(column, row, map.width, map.height);
            let expected = function(DVec3::new(d.x, -d.z, d.y));
            assert!((*texel - expected).length() < 0.08, "{index}: {texel} is not {expected}");
        }
    }
}
