//! Primitives, to which every shape is flattened, and groups of them that instances show.

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};

use super::deformation::Deformation;
use super::motion::{Motion, usable_inverse};

/// One primitive of the scene, in world space, or of a group, in the group's space.
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
    /// Whether rays that come straight from the camera pass it.
    pub unseen: bool,
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
    /// Disk of the radius `length(edge_u)` about `origin` that faces the point which it lights. Its axes are those of a sphere.
    FacingDisk,
}

impl PrimitiveShape {
    /// Whether the shape is a sphere, or a disk that may be turned to any side.
    pub fn is_round(self) -> bool {
        matches!(self, Self::Sphere | Self::FacingDisk)
    }
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
            PrimitiveShape::Sphere | PrimitiveShape::FacingDisk => Vec3::splat(self.edge_u.length()),
        };
        (self.origin - half, self.origin + half)
    }
}

/// Primitives that are stored once, in a space of their own, and shown by instances.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Group {
    /// The primitives.
    pub primitives: Vec<Primitive>,
    /// How some of them change their shape, in their order.
    pub deformations: Vec<Deformation>,
}

impl Group {
    /// Whether the group has a sphere, or a disk that faces what it lights.
    pub fn has_sphere(&self) -> bool {
        self.primitives.iter().any(|primitive| primitive.shape.is_round())
    }
}

/// Group in a place of the world.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Instance {
    /// Index into `Scene::groups`.
    pub group: u32,
    /// Images of the axes of the group's space.
    pub axes: [Vec3; 3],
    /// Image of the origin of the group's space.
    pub origin: Vec3,
    /// Index into `Scene::motions` where the transform depends on time. The axes and the origin are then those of the middle of that time.
    pub motion: Option<u32>,
}

impl Instance {
    /// A group in the place that an affine transform gives it.
    pub fn new(group: u32, world_from_group: &DMat4) -> Self {
        let [x, y, z, origin] = [0, 1, 2, 3].map(|column| world_from_group.col(column).truncate().as_vec3());
        Self { group, axes: [x, y, z], origin, motion: None }
    }

    /// A group that moves: `motion` has the index `index` in the scene.
    pub fn moving(group: u32, index: u32, motion: &Motion) -> Self {
        Self { motion: Some(index), ..Self::new(group, &motion.at(0.5)) }
    }

    /// Matrix of the transform of directions.
    pub fn world_from_group(&self) -> DMat3 {
        let [x, y, z] = self.axes.map(Vec3::as_dvec3);
        DMat3::from_cols(x, y, z)
    }

    /// Inverse of that matrix; `None` where the transform is no number, flattens the group, or shears it so much that roundings
    /// would show.
    pub fn group_from_world(&self) -> Option<DMat3> {
        usable_inverse(&self.world_from_group()).filter(|_| self.origin.is_finite())
    }

    /// Whether the group is shown where it is.
    pub fn is_identity(&self) -> bool {
        self.motion.is_none() && self.axes == [Vec3::X, Vec3::Y, Vec3::Z] && self.origin == Vec3::ZERO
    }

    /// Box in the world, as (minimum, maximum), of a box of the group.
    pub fn place_box(&self, (min, max): (Vec3, Vec3)) -> (DVec3, DVec3) {
        let [min, max] = [min, max].map(Vec3::as_dvec3);
        let matrix = self.world_from_group();
        let center = self.origin.as_dvec3() + matrix * (0.5 * (min + max));
        let half = matrix.abs() * (0.5 * (max - min));
        (center - half, center + half)
    }
}
