//! Set 1, Bvh: nodes, primitives and their attributes, in texel buffers where the device allows their size.

use std::sync::Arc;

use crate::Result;
use crate::encode::bvh::Bvh;
use crate::generated::kernels::bindings::bvh::{BVH_ATTRIBUTES, BVH_NODES, BVH_PRIMITIVES};
use crate::generated::kernels::{BVH_SET, Kernels};
use crate::generated::layout::TEXEL_BYTES;
use crate::gpu::{Buffer, Context, DescriptorSet};
use crate::renderer::sets::shapes::{buffer_kind, set_over, set_shape};

/// The hierarchy and the geometry of a scene on the device.
pub(crate) struct BvhSet {
    set: DescriptorSet,
}

impl BvhSet {
    /// Texels of the largest of the three buffers.
    pub fn texels(bvh: &Bvh) -> u64 {
        let bytes =
            size_of_val(&bvh.nodes[..]).max(size_of_val(&bvh.primitives[..])).max(size_of_val(&bvh.attributes[..]));
        (bytes / TEXEL_BYTES) as u64
    }

    pub fn new(context: &Arc<Context>, kernels: &Kernels, bvh: &Bvh) -> Result<Self> {
        let shape = set_shape(kernels, BVH_SET);
        let contents: [(u32, &str, &[u8]); 3] = [
            (BVH_NODES, "BVH nodes", bytemuck::cast_slice(&bvh.nodes)),
            (BVH_PRIMITIVES, "primitives", bytemuck::cast_slice(&bvh.primitives)),
            (BVH_ATTRIBUTES, "attributes", bytemuck::cast_slice(&bvh.attributes)),
        ];
        let upload = |(binding, name, bytes): (u32, &str, &[u8])| {
            Ok((binding, Buffer::with_values(context, name, bytes, buffer_kind(shape, binding))?))
        };
        let buffers = contents.into_iter().map(upload).collect::<Result<Vec<_>>>()?;
        let numbered: Vec<_> = buffers.iter().map(|(binding, buffer)| (*binding, buffer)).collect();
        Ok(Self { set: set_over(context, "bvh", shape, &numbered)? })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }
}
