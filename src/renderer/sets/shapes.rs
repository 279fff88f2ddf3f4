//! Buffers and descriptor sets in the shapes that kernels declare.

use std::sync::Arc;

use crate::Result;
use crate::generated::kernels::Kernels;
use crate::gpu::{BindingKind, Buffer, BufferKind, Context, DescriptorSet, SetShape};

/// The shape of the set of this number, which is the same for all kernels of a registry.
pub(super) fn set_shape(kernels: &Kernels, set: u32) -> &'static SetShape {
    &kernels.trace.sets[set as usize]
}

/// The kind of buffer that the read-only binding of this number takes.
pub(super) fn buffer_kind(shape: &SetShape, binding: u32) -> BufferKind {
    let binding = shape.bindings.iter().find(|shape| shape.binding == binding);
    match binding.map_or(BindingKind::StorageBuffer, |shape| shape.kind) {
        BindingKind::StorageBuffer => BufferKind::Storage,
        BindingKind::UniformBuffer => BufferKind::Uniform,
        BindingKind::TexelBufferFloat => BufferKind::TexelFloat,
        BindingKind::TexelBufferUint => BufferKind::TexelUint,
        BindingKind::AccelerationStructure => BufferKind::AccelerationStructure,
    }
}

/// The kind of buffer of single words that the read-only binding of this number takes.
pub(super) fn word_buffer_kind(shape: &SetShape, binding: u32) -> BufferKind {
    match buffer_kind(shape, binding) {
        BufferKind::TexelUint => BufferKind::TexelUint1,
        other => other,
    }
}

/// The kind of a table that kernels write as words and may read as texels: `texel` where the set has texel buffers.
pub(super) fn table_kind(shape: &SetShape, texel: BufferKind) -> BufferKind {
    let is_texel = |kind| matches!(kind, BindingKind::TexelBufferFloat | BindingKind::TexelBufferUint);
    let has_texels = shape.bindings.iter().any(|binding| is_texel(binding.kind));
    if has_texels { texel } else { BufferKind::Storage }
}

/// A set over `buffers`, each with the number of its binding. Buffers that no kernel of the registry reads are left out.
pub(super) fn set_over(
    context: &Arc<Context>,
    name: &str,
    shape: &SetShape,
    buffers: &[(u32, &Arc<Buffer>)],
) -> Result<DescriptorSet> {
    let buffer_of = |number: u32| buffers.iter().find(|(binding, _)| *binding == number).map(|(_, buffer)| *buffer);
    let used: Vec<_> = shape.bindings.iter().filter_map(|binding| buffer_of(binding.binding)).collect();
    DescriptorSet::new(context, name, shape, &used)
}
