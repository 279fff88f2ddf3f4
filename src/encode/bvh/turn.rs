//! Turns of triangles: which of their corners comes first.

use glam::Vec3;

use crate::scene::{Primitive, PrimitiveShape};

/// Turn of a triangle's corners: which of them comes first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turn(usize);

impl Turn {
    /// Turn after which a triangle begins at the vertex opposite its longest edge. Cross products of the two edges from there lose the
    /// fewest digits. From another corner of a slender triangle, hit points err by more than the offset of new rays.
    pub fn of(p: &Primitive) -> Self {
        if p.shape != PrimitiveShape::Triangle {
            return Self(0);
        }
        let [from_a, from_b, from_c] = [p.edge_v - p.edge_u, p.edge_v, p.edge_u].map(Vec3::length_squared);
        Self(if from_b > from_a.max(from_c) { 1 } else { usize::from(from_c > from_a) * 2 })
    }

    /// First vertex and edges of a triangle that begins at this corner of a triangle with these ones.
    pub fn triangle(self, origin: Vec3, edge_u: Vec3, edge_v: Vec3) -> [Vec3; 3] {
        let opposite = edge_v - edge_u;
        match self.0 {
            0 => [origin, edge_u, edge_v],
            1 => [origin + edge_u, opposite, -edge_u],
            _ => [origin + edge_v, -edge_v, -opposite],
        }
    }

    /// Turns what belongs to the corners.
    pub fn corners<T>(self, of_corners: &mut [T; 3]) {
        of_corners.rotate_left(self.0);
    }
}
