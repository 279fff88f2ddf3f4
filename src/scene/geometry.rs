//! Primitives, to which every shape is flattened.

use glam::{Vec2, Vec3};

/// One primitive of the scene, in world space.
///
/// A point on the three flat shapes is `origin + u * edge_u + v * edge_v`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Primitive {
    /// Shape, which gives the range of `(u, v)`.
    pub shape: PrimitiveShape,
    /// First vertex of a triangle; center of any other shape.
    pub origin: Vec3,
    /// Triangle: second vertex minus first. Parallelogram: half of one side. Disk: first semi-axis. Sphere: x-axis, as
    /// long as the radius.
    pub edge_u: Vec3,
    /// Triangle: third vertex minus first. Parallelogram: half of the other side. Disk: second semi-axis. Sphere:
    /// z-axis, as long as the radius.
    pub edge_v: Vec3,
    /// Unit shading normals at a triangle's vertices; `None` shades with the geometric normal.
    pub normals: Option<[Vec3; 3]>,
    /// Texture coordinates at a triangle's vertices. Texture coordinates of other shapes follow from their axes. A
    /// sphere's frame is right-handed (y = z x x) where these are 1, and left-handed where they are -1.
    pub uvs: [Vec2; 3],
    /// Whether the geometric normal is `-normalize(cross(edge_u, edge_v))`, or points into the sphere.
    pub flip_normal: bool,
    /// Whether rays that meet a flat shape from behind pass. The shading normal is on the front. Spheres are solid.
    pub front_only: bool,
    /// Index into `Scene::materials`.
    pub material: u32,
    /// Index into `Scene::emitters`; `None` where the primitive does not emit.
    pub emitter: Option<u32>,
}

/// Shapes of primitives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum PrimitiveShape {
    /// Triangle: `u >= 0`, `v >= 0`, `u + v <= 1`.
    Triangle,
    /// Parallelogram: `u` and `v` in [-1, 1].
    Parallelogram,
    /// Disk: `u^2 + v^2 <= 1`.
    Disk,
    /// Sphere: all points at the distance `length(edge_u)` from `origin`.
    Sphere,
}

impl Primitive {
    /// Smallest axis-aligned box that holds the primitive, as (minimum, maximum).
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let half = match self.shape {
            PrimitiveShape::Triangle => {
                let (b, c) = (self.origin + self.edge_u, self.origin + self.edge_v);
                return (self.origin.min(b).min(c), self.origin.max(b).max(c));
            }
            PrimitiveShape::Parallelogram => self.edge_u.abs() + self.edge_v.abs(),
            PrimitiveShape::Disk => (self.edge_u * self.edge_u + self.edge_v * self.edge_v).map(f32::sqrt),
            PrimitiveShape::Sphere => Vec3::splat(self.edge_u.length()),
        };
        (self.origin - half, self.origin + half)
    }
}
