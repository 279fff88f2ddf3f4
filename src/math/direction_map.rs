//! Direction maps: a map takes the square [-1, 1]^2 to the unit sphere. The square is cut into `resolution` x `resolution` bins,
//! numbered row by row from the corner (-1, -1). All bins of a map have the same solid angle. GLSL:
//! `glsl/include/math/direction_map.glsl`.

use glam::{DVec2, DVec3, dvec2};
use strum::{EnumMessage, IntoStaticStr, VariantArray};

use super::{cylindrical, equal_area};
use crate::generated::constants;

/// Map between directions and the square of their bins. Equal areas of the square are equal solid angles.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    EnumMessage,
    IntoStaticStr,
    VariantArray,
)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
#[repr(u32)]
pub enum DirectionMap {
    /// The upper hemisphere in the middle of the square, the lower one in its corners (Shirley and Chiu 1997; Clarberg 2008).
    EqualArea = constants::MAP_EQUAL_AREA,
    /// Azimuth and cosine about the z-axis (Lambert).
    Cylindrical = constants::MAP_CYLINDRICAL,
}

/// Unit direction of a point of the map's square [-1, 1]^2.
pub fn map_to_sphere(map: DirectionMap, p: DVec2) -> DVec3 {
    match map {
        DirectionMap::EqualArea => equal_area::square_to_sphere(p),
        DirectionMap::Cylindrical => cylindrical::cylinder_to_sphere(p),
    }
}

/// Unit direction of a bin's center.
pub fn bin_center(map: DirectionMap, bin: u32, resolution: u32) -> DVec3 {
    bin_point(map, bin, resolution, dvec2(0.5, 0.5))
}

/// Unit direction of a point of a bin. `within` is the point's place in the bin, in [0, 1]^2.
pub fn bin_point(map: DirectionMap, bin: u32, resolution: u32, within: DVec2) -> DVec3 {
    let corner = dvec2(f64::from(bin % resolution), f64::from(bin / resolution));
    map_to_sphere(map, 2.0 * (corner + within) / f64::from(resolution) - 1.0)
}

/// Unit normal that stands for all normals of its bin. Normal bins are bins of the equal-area map.
pub fn representative_normal(bin: u32, resolution: u32) -> DVec3 {
    bin_center(DirectionMap::EqualArea, bin, resolution)
}
