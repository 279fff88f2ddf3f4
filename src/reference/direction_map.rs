//! Twin of `glsl/include/math/direction_map.glsl`: bins of directions on either map, and of normals.

use glam::{DVec2, DVec3, dvec2};

use super::{cylindrical, equal_area};
use crate::settings::DirectionMap;

/// Unit direction of a point of the map.
pub fn map_to_sphere(map: DirectionMap, p: DVec2) -> DVec3 {
    match map {
        DirectionMap::EqualArea => equal_area::square_to_sphere(p),
        DirectionMap::Cylindrical => cylindrical::cylinder_to_sphere(p),
    }
}

/// Point of the map of a unit direction.
pub fn sphere_to_map(map: DirectionMap, w: DVec3) -> DVec2 {
    match map {
        DirectionMap::EqualArea => equal_area::sphere_to_square(w),
        DirectionMap::Cylindrical => cylindrical::sphere_to_cylinder(w),
    }
}

/// The point whose direction is opposite to that of `p`.
pub fn map_antipode(map: DirectionMap, p: DVec2) -> DVec2 {
    match map {
        DirectionMap::EqualArea => equal_area::antipode(p),
        DirectionMap::Cylindrical => cylindrical::cylinder_antipode(p),
    }
}

/// Bin of a unit direction at `resolution` bins a side, row by row.
pub fn direction_bin(map: DirectionMap, w: DVec3, resolution: u32) -> u32 {
    equal_area::square_bin(sphere_to_map(map, w), resolution)
}

/// Direction of a bin's center.
pub fn bin_center(map: DirectionMap, bin: u32, resolution: u32) -> DVec3 {
    bin_point(map, bin, resolution, dvec2(0.5, 0.5))
}

/// Direction of a point of a bin, given in [0, 1]^2 of that bin.
pub fn bin_point(map: DirectionMap, bin: u32, resolution: u32, within: DVec2) -> DVec3 {
    let corner = dvec2(f64::from(bin % resolution), f64::from(bin / resolution));
    map_to_sphere(map, 2.0 * (corner + within) / f64::from(resolution) - 1.0)
}

/// Bin of a unit normal.
pub fn normal_bin(n: DVec3, resolution: u32) -> u32 {
    direction_bin(DirectionMap::EqualArea, n, resolution)
}

/// The normal that stands for all of its bin.
pub fn representative_normal(bin: u32, resolution: u32) -> DVec3 {
    bin_center(DirectionMap::EqualArea, bin, resolution)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAPS: [DirectionMap; 2] = [DirectionMap::EqualArea, DirectionMap::Cylindrical];

    #[test]
    fn the_maps_are_invertible_and_unit() {
        let points = (0..10_000_u32).map(|i| (f64::from(i % 100), f64::from(i / 100)));
        for p in points.map(|(x, y)| dvec2((x + 0.37) / 50.0 - 1.0, (y + 0.61) / 50.0 - 1.0)) {
            for map in MAPS {
                let w = map_to_sphere(map, p);
                assert!((w.length() - 1.0).abs() < 1e-12);
                assert!((sphere_to_map(map, w) - p).length() < 1e-9, "{p} became {}", sphere_to_map(map, w));
                assert!((map_to_sphere(map, map_antipode(map, p)) + w).length() < 1e-12);
            }
        }
    }

    #[test]
    fn equal_areas_have_equal_moments() {
        // The mean of z^2 over the sphere is 1/3, and of every odd power 0: both fail for a map that is not equal-area.
        let n = 400;
        for map in MAPS {
            let mut moments = [0.0; 3];
            for i in 0..n * n {
                let w = bin_center(map, i, n);
                moments = [moments[0] + w.z * w.z, moments[1] + w.x.powi(3), moments[2] + w.x * w.x];
            }
            let mean = moments.map(|m| m / f64::from(n * n));
            assert!((mean[0] - 1.0 / 3.0).abs() < 1e-4 && mean[1].abs() < 1e-10 && (mean[2] - 1.0 / 3.0).abs() < 1e-4);
        }
    }
}
