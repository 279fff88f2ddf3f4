//! Symmetries of the direction maps that map bins to bins: reflections of the sphere in its coordinate planes, and the
//! reflection that exchanges x and y.

use crate::settings::DirectionMap;

/// Symmetry of the sphere: one reflection or several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Symmetry {
    mirror_x: bool,
    mirror_y: bool,
    mirror_z: bool,
    exchange: bool,
}

/// Symmetries, of all sixteen, that map bins to bins both in a map of directions and in the equal-area map of normals.
pub(super) fn symmetries(map: DirectionMap, directions: u32, normals: u32) -> Vec<Symmetry> {
    let bit = |i: u32, place: u32| i >> place & 1 == 1;
    let symmetry = |i| Symmetry { mirror_x: bit(i, 0), mirror_y: bit(i, 1), exchange: bit(i, 2), mirror_z: bit(i, 3) };
    let keeps = |map, side| move |symmetry: &Symmetry| symmetry.keeps_bins(map, side);
    (0..16).map(symmetry).filter(keeps(map, directions)).filter(keeps(DirectionMap::EqualArea, normals)).collect()
}

impl Symmetry {
    fn keeps_bins(self, map: DirectionMap, side: u32) -> bool {
        match map {
            // The middle bins of an odd resolution lie in both hemispheres.
            DirectionMap::EqualArea => !self.mirror_z || side.is_multiple_of(2),
            // The mirror adds half a turn to the azimuth, the exchange a quarter.
            DirectionMap::Cylindrical => {
                (!self.mirror_x || side.is_multiple_of(2)) && (!self.exchange || side.is_multiple_of(4))
            }
        }
    }

    /// Image of a bin in a map of `side * side` bins.
    pub fn image(self, map: DirectionMap, bin: u32, side: u32) -> u32 {
        // Centers of bins in units of half a bin, from the middle of the map.
        let side = side as i32;
        let center = |index: u32| 2 * index as i32 + 1 - side;
        let (x, y) = (center(bin % side as u32), center(bin / side as u32));
        let (x, y) = match map {
            DirectionMap::EqualArea => self.image_on_square(x, y, side),
            DirectionMap::Cylindrical => self.image_on_cylinder(x, y, side),
        };
        ((y + side - 1) / 2 * side + (x + side - 1) / 2) as u32
    }

    fn image_on_square(self, mut x: i32, mut y: i32, side: i32) -> (i32, i32) {
        if self.mirror_x {
            x = -x;
        }
        if self.mirror_y {
            y = -y;
        }
        if self.exchange {
            (x, y) = (y, x);
        }
        if self.mirror_z {
            (x, y) = ((side - y.abs()) * x.signum(), (side - x.abs()) * y.signum());
        }
        (x, y)
    }

    /// Image of a point of the cylindrical map. A whole turn of `azimuth` is twice `side`.
    fn image_on_cylinder(self, mut azimuth: i32, height: i32, side: i32) -> (i32, i32) {
        if self.mirror_x {
            azimuth = side - azimuth;
        }
        if self.mirror_y {
            azimuth = -azimuth;
        }
        if self.exchange {
            azimuth = side / 2 - azimuth;
        }
        ((azimuth + side).rem_euclid(2 * side) - side, if self.mirror_z { -height } else { height })
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};

    use super::*;
    use crate::math::direction_map::bin_center;

    fn image_of_direction(symmetry: Symmetry, w: DVec3) -> DVec3 {
        let sign = |mirror: bool| if mirror { -1.0 } else { 1.0 };
        let w = w * dvec3(sign(symmetry.mirror_x), sign(symmetry.mirror_y), sign(symmetry.mirror_z));
        if symmetry.exchange { dvec3(w.y, w.x, w.z) } else { w }
    }

    #[test]
    fn centers_go_where_bins_go() {
        for map in [DirectionMap::EqualArea, DirectionMap::Cylindrical] {
            for side in [4, 6, 16, 5, 9] {
                for symmetry in symmetries(map, side, side) {
                    for bin in 0..side * side {
                        let expected = image_of_direction(symmetry, bin_center(map, bin, side));
                        let found = bin_center(map, symmetry.image(map, bin, side), side);
                        assert!((found - expected).length() < 1.0e-12, "{map:?}, {symmetry:?} of bin {bin} of {side}");
                    }
                }
            }
        }
    }
}
