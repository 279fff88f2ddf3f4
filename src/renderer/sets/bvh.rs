//! Set 1, Bvh: nodes, primitives and their attributes, in texel buffers where the device allows their size. With ray queries, an
//! acceleration structure takes the place of the nodes.

use std::borrow::Cow;
use std::sync::Arc;

use glam::Vec3;

use crate::encode::bvh::Bvh;
use crate::encode::query_geometry::{MARGIN, QueryGeometry};
use crate::generated::kernels::bindings::bvh::{
    BVH_ATTRIBUTES, BVH_ELEMENTS, BVH_NODES, BVH_PRIMITIVES, BVH_STRUCTURE,
};
use crate::generated::kernels::{BVH_SET, Kernels};
use crate::generated::layout::TEXEL_BYTES;
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet, StructurePart};
use crate::renderer::sets::shapes::{buffer_kind, set_over, set_shape};
use crate::{Error, Result};

/// The hierarchy and the geometry of a scene on the device.
pub(crate) struct BvhSet {
    set: DescriptorSet,
    /// Place of the eye for which an acceleration structure was built, and the reach of its rays.
    built_for: Option<(Vec3, f64)>,
}

/// Distance, as a multiple of the reach, from the eye of an acceleration structure to another one whose rays it covers: its margin covers
/// rays from eight times the reach.
const MOST_FROM_EYE: f64 = 7.0;

impl BvhSet {
    /// Texels of the largest of the three buffers.
    pub fn texels(bvh: &Bvh) -> u64 {
        let primitives =
            size_of_val(&bvh.primitives[..]) + size_of_val(&bvh.keys[..]) + size_of_val(&bvh.motions.records[..]);
        let bytes = size_of_val(&bvh.nodes[..]).max(primitives).max(size_of_val(&bvh.attributes[..]));
        (bytes / TEXEL_BYTES) as u64
    }

    /// Uploads the hierarchy, or, where the kernels ask ray queries, has the device build its own, seen from `eye`.
    pub fn new(context: &Arc<Context>, kernels: &Kernels, bvh: &Bvh, eye: Vec3) -> Result<Self> {
        let shape = set_shape(kernels, BVH_SET);
        let has = |number: u32| shape.bindings.iter().any(|binding| binding.binding == number);
        let of_primitives: &[u8] = bytemuck::cast_slice(&bvh.primitives);
        let primitives: Cow<[u8]> = match (bytemuck::cast_slice(&bvh.keys), bytemuck::cast_slice(&bvh.motions.records))
        {
            ([], []) => Cow::Borrowed(of_primitives),
            (keys, motions) => Cow::Owned([of_primitives, keys, motions].concat()),
        };
        let contents: [(u32, &str, &[u8]); 3] = [
            (BVH_NODES, "BVH nodes", bytemuck::cast_slice(&bvh.nodes)),
            (BVH_PRIMITIVES, "primitives", &primitives),
            (BVH_ATTRIBUTES, "attributes", bytemuck::cast_slice(&bvh.attributes)),
        ];
        let upload = |(binding, name, bytes): (u32, &str, &[u8])| {
            Ok((binding, Buffer::with_values(context, name, bytes, buffer_kind(shape, binding))?))
        };
        let used = contents.into_iter().filter(|(binding, ..)| has(*binding));
        let mut buffers = used.map(upload).collect::<Result<Vec<_>>>()?;
        let mut built_for = None;
        if has(BVH_STRUCTURE) {
            let geometry = QueryGeometry::new(bvh, eye, MARGIN);
            buffers.extend(query_buffers(context, &geometry)?);
            built_for = Some((eye, geometry.reach));
        }
        let numbered: Vec<_> = buffers.iter().map(|(binding, buffer)| (*binding, buffer)).collect();
        Ok(Self { set: set_over(context, "bvh", shape, &numbered)?, built_for })
    }

    /// Whether this is the set of the same geometry seen from `eye`.
    pub fn is_seen_from(&self, eye: Vec3) -> bool {
        self.built_for.is_none_or(|(first, _)| first == eye)
    }

    /// Refuses an eye from which rays come that the acceleration structure does not cover.
    pub fn check_eye(&self, eye: Vec3) -> Result<()> {
        match self.built_for {
            Some((first, reach)) if f64::from(eye.distance(first)) > MOST_FROM_EYE * reach => {
                let message =
                    "the camera is too far from its first place for the device's ray queries; take --traversal compute";
                Err(Error::Settings(message.into()))
            }
            _ => Ok(()),
        }
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }
}

/// The acceleration structure and the primitives of its elements, with the numbers of their bindings.
fn query_buffers(context: &Arc<Context>, geometry: &QueryGeometry) -> Result<[(u32, Arc<Buffer>); 2]> {
    let elements = Buffer::with_values(context, "elements", &geometry.elements, BufferKind::Storage)?;
    let parts = [
        StructurePart::OpaqueTriangles(&geometry.opaque),
        StructurePart::Triangles(&geometry.front_only),
        StructurePart::Boxes(&geometry.boxes),
    ];
    let structure = Buffer::acceleration_structure(context, "the scene", &parts)?;
    Ok([(BVH_STRUCTURE, structure), (BVH_ELEMENTS, elements)])
}
