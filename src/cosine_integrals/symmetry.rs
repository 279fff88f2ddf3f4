//! The symmetries of the equal-area map that take bins to bins: reflections of the sphere in its coordinate planes, and that
//! which exchanges x and y.

/// A symmetry of the sphere, a reflection or several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Symmetry {
    mirror_x: bool,
    mirror_y: bool,
    mirror_z: bool,
    exchange: bool,
}

/// All sixteen, or without those that turn the hemispheres over: these split the middle bins of an odd resolution.
pub(super) fn symmetries(with_z: bool) -> Vec<Symmetry> {
    let bit = |i: u32, place: u32| i >> place & 1 == 1;
    let symmetry = |i| Symmetry { mirror_x: bit(i, 0), mirror_y: bit(i, 1), exchange: bit(i, 2), mirror_z: bit(i, 3) };
    (0..if with_z { 16 } else { 8 }).map(symmetry).collect()
}

impl Symmetry {
    /// Where it takes a bin of a map of `side * side` bins.
    pub fn image(self, bin: u32, side: u32) -> u32 {
        // Centers of bins in halves of a bin, from the middle of the map.
        let (side, mut x, mut y) = (side as i32, (bin % side) as i32, (bin / side) as i32);
        (x, y) = (2 * x + 1 - side, 2 * y + 1 - side);
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
        ((y + side - 1) / 2 * side + (x + side - 1) / 2) as u32
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};

    use super::*;
    use crate::reference::equal_area::bin_center;

    fn image_of_direction(symmetry: Symmetry, w: DVec3) -> DVec3 {
        let sign = |mirror: bool| if mirror { -1.0 } else { 1.0 };
        let w = w * dvec3(sign(symmetry.mirror_x), sign(symmetry.mirror_y), sign(symmetry.mirror_z));
        if symmetry.exchange { dvec3(w.y, w.x, w.z) } else { w }
    }

    #[test]
    fn centers_go_where_bins_go() {
        for side in [4, 6, 16, 5, 9] {
            for symmetry in symmetries(side % 2 == 0) {
                for bin in 0..side * side {
                    let expected = image_of_direction(symmetry, bin_center(bin, side));
                    let found = bin_center(symmetry.image(bin, side), side);
                    assert!((found - expected).length() < 1.0e-12, "{symmetry:?} of bin {bin} of {side}");
                }
            }
        }
    }
}
