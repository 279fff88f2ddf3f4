//! Primitives for tests.

use glam::Vec3;
use lodestar::scene::{Primitive, PrimitiveShape};

/// Primitive of the first material that does not emit.
pub fn primitive(shape: PrimitiveShape, origin: Vec3, edge_u: Vec3, edge_v: Vec3) -> Primitive {
    Primitive {
        shape,
        origin,
        edge_u,
        edge_v,
        normals: None,
        uvs: Default::default(),
        flip_normal: false,
        front_only: false,
        unseen: false,
        material: 0,
        emitter: None,
    }
}
