//! Meshes that change their shape while the shutter is open.

use std::ops::Range;

use glam::Vec3;

/// Most parts of the shutter's time at whose ends a mesh has vertices of its own.
pub const MOST_INTERVALS: usize = 16;

/// Triangles whose vertices move while the shutter is open. Their places are known at evenly spaced times, the first and the last of which
/// are those at which the shutter opens and closes. Between two of them, each vertex moves along a line.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Deformation {
    /// Index of the first triangle among the primitives of the scene or of the group. The others follow it.
    pub first: u32,
    /// Number of parts of the shutter's time: 1 to [`MOST_INTERVALS`].
    pub intervals: u32,
    /// Triangles at these times. Those of a triangle follow each other, and the first of them is the primitive.
    pub keys: Vec<DeformedTriangle>,
}

/// Triangle at a time.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct DeformedTriangle {
    /// The three vertices.
    pub vertices: [Vec3; 3],
    /// Unit shading normals at the vertices, where the primitive has any.
    pub normals: Option<[Vec3; 3]>,
}

impl DeformedTriangle {
    /// Smallest axis-aligned box that holds the triangle, as (minimum, maximum).
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let [a, b, c] = self.vertices;
        (a.min(b).min(c), a.max(b).max(c))
    }
}

impl Deformation {
    /// Indices of the triangles among the primitives.
    pub fn triangles(&self) -> Range<u32> {
        self.first..self.first + (self.keys.len() / self.keys_of_each()) as u32
    }

    /// Number of times at which the triangles are known.
    pub fn keys_of_each(&self) -> usize {
        self.intervals as usize + 1
    }

    /// The triangle with this index among the primitives, at all times.
    pub fn keys_of(&self, index: u32) -> &[DeformedTriangle] {
        let first = (index - self.first) as usize * self.keys_of_each();
        &self.keys[first..first + self.keys_of_each()]
    }

    /// Boxes of the triangles at all times, each with the index of its primitive.
    pub fn boxes(&self) -> impl Iterator<Item = (u32, (Vec3, Vec3))> + '_ {
        let each = self.keys_of_each();
        self.keys.iter().enumerate().map(move |(at, key)| (self.first + (at / each) as u32, key.bounds()))
    }
}

/// Place in the list of the deformation of the primitive with this index, if its vertices move. Deformations lie in the order of their
/// primitives.
pub(crate) fn deformation_of(deformations: &[Deformation], index: u32) -> Option<usize> {
    let after = deformations.partition_point(|deformation| deformation.first <= index);
    after.checked_sub(1).filter(|&at| deformations[at].triangles().contains(&index))
}

/// Takes the deformations of the primitives from the index `first` on, as those of a group that these become.
pub(in crate::scene) fn split_off(deformations: &mut Vec<Deformation>, first: usize) -> Vec<Deformation> {
    let at = deformations.partition_point(|deformation| (deformation.first as usize) < first);
    let mut of_group = deformations.split_off(at);
    of_group.iter_mut().for_each(|deformation| deformation.first -= first as u32);
    of_group
}
