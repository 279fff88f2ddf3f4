//! Set 1, Bvh: nodes, primitives and their attributes, in texel buffers where the device allows their size. With ray queries, an
//! acceleration structure takes the place of the nodes.

use std::borrow::Cow;
use std::sync::Arc;

use glam::Vec3;

use crate::Result;
use crate::encode::bvh::Bvh;
use crate::encode::query_geometry::{MARGIN, QueryGeometry};
use crate::generated::kernels::bindings::bvh::{
    BVH_ATTRIBUTES, BVH_ELEMENTS, BVH_NODES, BVH_PRIMITIVES, BVH_STRUCTURE,
};
use crate::generated::kernels::{BVH_SET, Kernels};
use crate::generated::layout::TEXEL_BYTES;
use crate::gpu::{Buffer, BufferKind, Context, DescriptorSet, StructurePart};
use crate::renderer::sets::shapes::{buffer_kind, set_over, set_shape};

/// The hierarchy and the geometry of a scene on the device.
pub(crate) struct BvhSet {
    set: DescriptorSet,
}

impl BvhSet {
    /// Texels of the largest of the three buffers.
    pub fn texels(bvh: &Bvh) -> u64 {
        let primitives = size_of_val(&bvh.primitives[..]) + size_of_val(&bvh.motions.records[..]);
        let bytes = size_of_val(&bvh.nodes[..]).max(primitives).max(size_of_val(&bvh.attributes[..]));
        (bytes / TEXEL_BYTES) as u64
    }

    /// Uploads the hierarchy, or, where the kernels ask ray queries, has the device build its own, seen from `eye`.
    pub fn new(context: &Arc<Context>, kernels: &Kernels, bvh: &Bvh, eye: Vec3) -> Result<Self> {
        let shape = set_shape(kernels, BVH_SET);
        let has = |number: u32| shape.bindings.iter().any(|binding| binding.binding == number);
        let primitives: Cow<[u8]> = match bytemuck::cast_slice(&bvh.motions.records) {
            [] => Cow::Borrowed(bytemuck::cast_slice(&bvh.primitives)),
            motions => Cow::Owned([bytemuck::cast_slice(&bvh.primitives), motions].concat()),
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
        if has(BVH_STRUCTURE) {
            buffers.extend(query_buffers(context, bvh, eye)?);
        }
        let numbered: Vec<_> = buffers.iter().map(|(binding, buffer)| (*binding, buffer)).collect();
        Ok(Self { set: set_over(context, "bvh", shape, &numbered)? })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }
}

/// The acceleration structure and the primitives of its elements, with the numbers of their bindings.
fn query_buffers(context: &Arc<Context>, bvh: &Bvh, eye: Vec3) -> Result<[(u32, Arc<Buffer>); 2]> {
    let geometry = QueryGeometry::new(bvh, eye, MARGIN);
    let elements = Buffer::with_values(context, "elements", &geometry.elements, BufferKind::Storage)?;
    let parts = [
        StructurePart::OpaqueTriangles(&geometry.opaque),
        StructurePart::Triangles(&geometry.front_only),
        StructurePart::Boxes(&geometry.boxes),
    ];
    let structure = Buffer::acceleration_structure(context, "the scene", &parts)?;
    Ok([(BVH_STRUCTURE, structure), (BVH_ELEMENTS, elements)])
}
