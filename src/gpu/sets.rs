//! Descriptor sets: the buffers that a kernel sees.

use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::context::Context;
use super::fault::failed;
use super::layout::{DESCRIPTOR_TYPES, SetLayout, descriptor_type};
use crate::Result;
use crate::generated::interface::{BindingKind, SetShape};

/// Descriptor set, written once. It keeps its buffers alive.
pub struct DescriptorSet {
    raw: vk::DescriptorSet,
    shape: SetShape,
    // Order of dropping: the pool with the set in it, then everything that the set refers to.
    pool: Pool,
    _layout: SetLayout,
    buffers: Vec<Arc<Buffer>>,
}

impl DescriptorSet {
    /// Makes a set of the given shape over buffers, sorted by their binding numbers.
    ///
    /// # Errors
    /// Where the device is out of memory.
    ///
    /// # Panics
    /// Where the buffers do not fit the shape or belong to another context.
    pub fn new(context: &Arc<Context>, name: &str, shape: &SetShape, buffers: &[&Arc<Buffer>]) -> Result<Self> {
        check_buffers(context, name, shape, buffers);
        let layout = SetLayout::new(context, name, shape)?;
        let pool = Pool::new(context, name, shape)?;
        let raw = pool.allocate(&layout, name)?;
        let buffers = buffers.iter().map(|&buffer| Arc::clone(buffer)).collect();
        let set = Self { raw, shape: *shape, pool, _layout: layout, buffers };
        set.write();
        Ok(set)
    }

    fn write(&self) {
        let whole: Vec<_> = self.buffers.iter().map(|buffer| [whole_buffer(buffer)]).collect();
        let views: Vec<_> = self.buffers.iter().map(|buffer| [buffer.view()]).collect();
        let structures: Vec<_> = self.buffers.iter().map(|buffer| [buffer.structure()]).collect();
        let mut structures: Vec<_> = structures
            .iter()
            .map(|structure| {
                vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(structure)
            })
            .collect();
        let bindings = self.shape.bindings.iter().zip(&mut structures).enumerate();
        let writes = bindings.map(|(place, (binding, structure))| {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(self.raw)
                .dst_binding(binding.binding)
                .descriptor_type(descriptor_type(binding.kind));
            match binding.kind {
                BindingKind::StorageBuffer | BindingKind::UniformBuffer => write.buffer_info(&whole[place]),
                BindingKind::TexelBufferFloat | BindingKind::TexelBufferUint => write.texel_buffer_view(&views[place]),
                BindingKind::AccelerationStructure => write.descriptor_count(1).push_next(structure),
            }
        });
        let writes: Vec<_> = writes.collect();
        // SAFETY: invariant 1: the set was just allocated and is owned by this value alone, the buffers are alive, and
        // all that the writes point to are locals. Each binding and its kind are the layout's.
        unsafe { self.pool.context.raw().update_descriptor_sets(&writes, &[]) }
    }

    /// Handle of the set, for a call during which the caller borrows this value.
    pub(super) fn raw(&self) -> vk::DescriptorSet {
        self.raw
    }

    pub(super) fn shape(&self) -> &SetShape {
        &self.shape
    }

    pub(super) fn context(&self) -> &Arc<Context> {
        &self.pool.context
    }
}

fn whole_buffer(buffer: &Buffer) -> vk::DescriptorBufferInfo {
    vk::DescriptorBufferInfo::default().buffer(buffer.backing().raw()).range(buffer.len_bytes())
}

fn check_buffers(context: &Arc<Context>, name: &str, shape: &SetShape, buffers: &[&Arc<Buffer>]) {
    let (expected, given) = (shape.bindings.len(), buffers.len());
    assert!(expected == given, "the set `{name}` has {expected} bindings, but {given} buffers were given");
    for (binding, buffer) in shape.bindings.iter().zip(buffers) {
        let (expected, given) = (binding.kind, buffer.kind());
        let place = binding.name;
        let is_whole = expected != BindingKind::AccelerationStructure || buffer.structure() != Default::default();
        assert!(is_whole, "`{name}.{place}` has no acceleration structure");
        assert!(given.fits(expected), "`{name}.{place}` is {expected:?}, but `{}` is {given:?}", buffer.name());
        assert!(Arc::ptr_eq(context, buffer.context()), "`{}` belongs to another context than `{name}`", buffer.name());
    }
}

/// Descriptor pool for one set.
struct Pool {
    raw: vk::DescriptorPool,
    context: Arc<Context>,
}

impl Pool {
    fn new(context: &Arc<Context>, name: &str, shape: &SetShape) -> Result<Self> {
        let size = |ty| {
            let bindings = shape.bindings.iter().filter(|binding| descriptor_type(binding.kind) == ty);
            vk::DescriptorPoolSize::default().ty(ty).descriptor_count(bindings.count() as u32)
        };
        let sizes = DESCRIPTOR_TYPES.map(size);
        // Vulkan forbids a size of zero but allows an empty list of sizes.
        let sizes: Vec<_> = sizes.into_iter().filter(|size| size.descriptor_count > 0).collect();
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: invariant 1: the device is alive, and all that `info` points to are locals.
        let raw = unsafe { context.raw().create_descriptor_pool(&info, None) }
            .map_err(failed(format!("creating the descriptor pool of `{name}`")))?;
        context.logical().name(raw, name);
        Ok(Self { raw, context: Arc::clone(context) })
    }

    fn allocate(&self, layout: &SetLayout, name: &str) -> Result<vk::DescriptorSet> {
        let layouts = [layout.raw()];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.raw).set_layouts(&layouts);
        // SAFETY: invariant 1: device, layout and pool are alive, and the pool is seen by this thread alone.
        let sets = unsafe { self.context.raw().allocate_descriptor_sets(&info) }
            .map_err(failed(format!("allocating the descriptor set `{name}`")))?;
        self.context.logical().name(sets[0], name);
        Ok(sets[0])
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 3: pool and set are owned by this value alone, and no submission that used them is
        // under way.
        unsafe { self.context.raw().destroy_descriptor_pool(self.raw, None) }
    }
}
