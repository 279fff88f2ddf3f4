//! Set 1, Bvh: nodes, primitives and their attributes, in texel buffers where the device allows their size.

use std::sync::Arc;

use crate::Result;
use crate::encode::bvh::Bvh;
use crate::generated::kernels::Kernels;
use crate::gpu::{Buffer, Context, DescriptorSet};
use crate::renderer::{buffer_kind, set_shape};

const TEXEL_BYTES: u64 = 16;

/// The geometry of a scene on the device.
pub(crate) struct Geometry {
    set: DescriptorSet,
}

impl Geometry {
    /// Texels of the largest of the three buffers.
    pub fn texels(bvh: &Bvh) -> u64 {
        let bytes =
            size_of_val(&bvh.nodes[..]).max(size_of_val(&bvh.primitives[..])).max(size_of_val(&bvh.attributes[..]));
        bytes as u64 / TEXEL_BYTES
    }

    pub fn new(context: &Arc<Context>, kernels: &Kernels, bvh: &Bvh) -> Result<Self> {
        let shape = set_shape(kernels, 1);
        let contents: [(&str, &[u8]); 3] = [
            ("BVH nodes", bytemuck::cast_slice(&bvh.nodes)),
            ("primitives", bytemuck::cast_slice(&bvh.primitives)),
            ("attributes", bytemuck::cast_slice(&bvh.attributes)),
        ];
        let buffers = contents
            .iter()
            .zip(shape.bindings)
            .map(|((name, bytes), binding)| Buffer::with_values(context, name, bytes, buffer_kind(binding.kind)));
        let buffers = buffers.collect::<Result<Vec<_>>>()?;
        let set = DescriptorSet::new(context, "bvh", shape, &buffers.iter().collect::<Vec<_>>())?;
        Ok(Self { set })
    }

    pub fn set(&self) -> &DescriptorSet {
        &self.set
    }
}
