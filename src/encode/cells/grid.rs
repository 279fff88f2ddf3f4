//! Regular grid over a scene, in whose places cells lie.

use glam::{UVec3, Vec3, uvec3};

use crate::encode::bvh::Bvh;

/// Least extent of the scene along an axis, relative to its largest coordinate.
const THINNEST: f32 = 1.0e-6;

/// Regular grid over a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Lower corner, world space.
    pub origin: Vec3,
    /// Places per unit of length, along each axis.
    pub per_unit: Vec3,
    /// Number of places along each axis.
    pub size: UVec3,
}

impl Grid {
    /// Grid of `size` places over the scene's box.
    pub fn new(bvh: &Bvh, size: UVec3) -> Self {
        Self { origin: bvh.bounds.0, per_unit: size.as_vec3() / extent(bvh), size }
    }

    /// Lower and upper corner of the box.
    pub fn bounds(&self) -> [Vec3; 2] {
        [self.origin, self.origin + self.size.as_vec3() / self.per_unit]
    }

    /// Coordinates of a point, in places from the lower corner.
    pub(super) fn coordinates(&self, position: Vec3) -> Vec3 {
        (position - self.origin) * self.per_unit
    }

    /// Place at the given coordinates; for coordinates outside, the nearest place.
    pub(super) fn clamped(&self, coordinates: Vec3) -> UVec3 {
        coordinates.clamp(Vec3::ZERO, self.size.as_vec3() - 0.5).as_uvec3()
    }

    /// Lower and upper corner of a place, world space.
    pub fn place_bounds(&self, place: UVec3) -> (Vec3, Vec3) {
        let corner = |place: UVec3| self.origin + place.as_vec3() / self.per_unit;
        (corner(place), corner(place + 1))
    }

    /// Index of a place, with the x-axis running fastest.
    pub(super) fn index(&self, place: UVec3) -> usize {
        ((place.z * self.size.y + place.y) * self.size.x + place.x) as usize
    }

    pub(crate) fn place_count(&self) -> usize {
        self.size.element_product() as usize
    }

    /// All places within the given bounds, both included.
    pub(super) fn places(from: UVec3, to: UVec3) -> impl Iterator<Item = UVec3> {
        (from.z..=to.z)
            .flat_map(move |z| (from.y..=to.y).flat_map(move |y| (from.x..=to.x).map(move |x| uvec3(x, y, z))))
    }
}

/// Extents of the scene's box, all above zero.
pub(super) fn extent(bvh: &Bvh) -> Vec3 {
    (bvh.bounds.1 - bvh.bounds.0).max(Vec3::splat(bvh.largest_coordinate().max(1.0e-20) * THINNEST))
}
