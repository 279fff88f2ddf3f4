//! Layouts of descriptor sets and pipelines.

use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::fault::failed;
use crate::Result;
use crate::generated::interface::{BindingKind, BindingShape, KernelSource, SetShape};

/// All types that [`descriptor_type`] can return.
pub(super) const DESCRIPTOR_TYPES: [vk::DescriptorType; 4] = [
    vk::DescriptorType::STORAGE_BUFFER,
    vk::DescriptorType::UNIFORM_BUFFER,
    vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
    vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
];

/// Vulkan's descriptor type for a kind of binding.
pub(super) fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
        BindingKind::TexelBufferFloat | BindingKind::TexelBufferUint => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        BindingKind::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
    }
}

/// Whether a set of one shape can be bound where the other is expected. Names are not compared.
pub(super) fn shapes_match(a: &[BindingShape], b: &[BindingShape]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a.binding, a.kind) == (b.binding, b.kind))
}

/// Layout of one descriptor set. Equal shapes give layouts that Vulkan calls identically defined.
pub(super) struct SetLayout {
    raw: vk::DescriptorSetLayout,
    context: Arc<Context>,
}

impl SetLayout {
    pub(super) fn new(context: &Arc<Context>, name: &str, shape: &SetShape) -> Result<Self> {
        let binding = |shape: &BindingShape| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(shape.binding)
                .descriptor_type(descriptor_type(shape.kind))
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::COMPUTE)
        };
        let bindings: Vec<_> = shape.bindings.iter().map(binding).collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: invariant 1: the device is alive, and all that `info` points to are locals.
        let raw = unsafe { context.raw().create_descriptor_set_layout(&info, None) }
            .map_err(failed(format!("creating the layout of set {} of `{name}`", shape.set)))?;
        context.logical().name(raw, name);
        Ok(Self { raw, context: Arc::clone(context) })
    }

    /// Handle of the layout, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::DescriptorSetLayout {
        self.raw
    }
}

impl Drop for SetLayout {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 3: owned by this value alone, and no submission is under way that used a set or
        // pipeline made with it.
        unsafe { self.context.raw().destroy_descriptor_set_layout(self.raw, None) }
    }
}

/// Layout of a kernel's pipeline: its sets and its push constants.
pub(super) struct PipelineLayout {
    raw: vk::PipelineLayout,
    // Declared after the pipeline layout that is made from them, so dropped later.
    _sets: Vec<SetLayout>,
    context: Arc<Context>,
}

impl PipelineLayout {
    pub(super) fn new(context: &Arc<Context>, source: &KernelSource) -> Result<Self> {
        let sets = source.sets.iter().map(|shape| SetLayout::new(context, source.name, shape));
        let sets = sets.collect::<Result<Vec<_>>>()?;
        let raw_sets: Vec<_> = sets.iter().map(SetLayout::raw).collect();
        let push_constants = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(source.push_constant_bytes)];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&raw_sets);
        if source.push_constant_bytes > 0 {
            info = info.push_constant_ranges(&push_constants);
        }
        // SAFETY: invariant 1: the device and the set layouts are alive, and all that `info` points to are locals.
        let raw = unsafe { context.raw().create_pipeline_layout(&info, None) }
            .map_err(failed(format!("creating the pipeline layout of `{}`", source.name)))?;
        context.logical().name(raw, source.name);
        Ok(Self { raw, _sets: sets, context: Arc::clone(context) })
    }

    /// Handle of the layout, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::PipelineLayout {
        self.raw
    }

    pub(super) fn context(&self) -> &Arc<Context> {
        &self.context
    }
}

impl Drop for PipelineLayout {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 3: owned by this value alone, and no submission that used it is under way.
        unsafe { self.context.raw().destroy_pipeline_layout(self.raw, None) }
    }
}
