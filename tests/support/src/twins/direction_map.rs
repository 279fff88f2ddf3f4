//! Twin of `glsl/include/math/direction_map.glsl`: points and bins of unit directions on either map, and bins of
//! normals. The inverse, from points and bins to directions, is [`lodestar::math::direction_map`].

use glam::{DVec2, DVec3};
use lodestar::settings::DirectionMap;

use super::{cylindrical, equal_area};

/// Point of the map for a unit direction.
pub fn sphere_to_map(map: DirectionMap, w: DVec3) -> DVec2 {
    match map {
        DirectionMap::EqualArea => equal_area::sphere_to_square(w),
        DirectionMap::Cylindrical => cylindrical::sphere_to_cylinder(w),
    }
}

/// Point whose direction is opposite to that of `p`.
pub fn map_antipode(map: DirectionMap, p: DVec2) -> DVec2 {
    match map {
        DirectionMap::EqualArea => equal_area::antipode(p),
        DirectionMap::Cylindrical => cylindrical::cylinder_antipode(p),
    }
}

/// Bin of a unit direction, with `resolution` bins along each side, row by row.
pub fn direction_bin(map: DirectionMap, w: DVec3, resolution: u32) -> u32 {
    equal_area::square_bin(sphere_to_map(map, w), resolution)
}

/// Bin of a unit normal.
pub fn normal_bin(n: DVec3, resolution: u32) -> u32 {
    direction_bin(DirectionMap::EqualArea, n, resolution)
}
