//! Recorders: a submission's dispatches, fills and copies.

use std::marker::PhantomData;
use std::sync::Arc;
use std::time::Duration;

use ash::{khr, vk};

use super::backing::{Backing, check_range};
use super::buffer::Buffer;
use super::context::Context;
use super::debug::c_name;
use super::fault::failed;
use super::kernel::Kernel;
use super::layout::shapes_match;
use super::queries::Timestamps;
use super::sets::DescriptorSet;
use super::slot::Slot;
use super::timing::{Clock, DispatchTime};
use crate::Result;

/// Records work, in order. Dispatches, fills and copies may overlap unless a [`barrier`](Self::barrier) stands between
/// them.
///
/// Everything recorded is borrowed for `'a`. The caller of [`Context::submit`] chooses `'a`, so it lasts longer than
/// that call.
pub struct Recorder<'a> {
    // Owned, not borrowed: if a caller swaps two recorders, each keeps a living command buffer.
    slot: Slot,
    // One entry per dispatch so far; `None` where no record is kept.
    dispatches: Option<Vec<DispatchTime>>,
    times_dispatches: bool,
    // Invariant in 'a, so that no reborrowing of the recorder can shorten it.
    borrows: PhantomData<fn(&'a ()) -> &'a ()>,
}

const KERNEL_AND_COPY: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::COMPUTE_SHADER.as_raw() | vk::PipelineStageFlags::TRANSFER.as_raw(),
);

impl<'a> Recorder<'a> {
    pub(super) fn begin(context: &Arc<Context>, label: &str) -> Result<Self> {
        let record = context.timings().clock();
        let slot = Slot::take(context)?;
        context.logical().name(slot.commands(), label);
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: invariant 1: the command buffer is freshly reset and owned by this recorder.
        unsafe { context.raw().begin_command_buffer(slot.commands(), &info) }
            .map_err(failed("vkBeginCommandBuffer"))?;
        if let Some(timestamps) = slot.timestamps() {
            timestamps.start(slot.commands());
        }
        let (dispatches, times_dispatches) = (record.map(|_| Vec::new()), record == Some(Clock::Device));
        Ok(Self { slot, dispatches, times_dispatches, borrows: PhantomData })
    }

    /// Makes all writes visible to the host and to later submissions, and ends recording.
    pub(super) fn end(&mut self) -> Result<&Slot> {
        self.memory_barrier(vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ | vk::AccessFlags::HOST_WRITE);
        if let Some(timestamps) = self.slot.timestamps() {
            timestamps.stop(self.commands());
        }
        // SAFETY: invariant 1: the command buffer is owned by this recorder and being recorded.
        unsafe { self.device().end_command_buffer(self.commands()) }.map_err(failed("vkEndCommandBuffer"))?;
        Ok(&self.slot)
    }

    /// Time that the work took by the device's clock, once the submission is done.
    pub(super) fn elapsed(&self) -> Option<Duration> {
        self.slot.timestamps()?.elapsed()
    }

    /// Dispatches with their times, once the submission is done; empty where no record is kept.
    pub(super) fn dispatch_times(&mut self) -> Vec<DispatchTime> {
        let mut dispatches = self.dispatches.take().unwrap_or_default();
        let timestamps = self.slot.timestamps().filter(|_| self.times_dispatches);
        for (place, dispatch) in dispatches.iter_mut().enumerate() {
            dispatch.span = timestamps.as_ref().and_then(|timestamps| timestamps.span(place));
        }
        dispatches
    }

    /// Runs a kernel over `groups` workgroups. `sets` are the kernel's sets 0, 1, ...; where the kernel's set is empty,
    /// any set may be given, and empty sets at the end may be left out. `push` is the push-constant block
    /// (`bytemuck::bytes_of`), empty where the kernel has none.
    ///
    /// # Panics
    /// Where sets or push constants do not fit the kernel, there are more groups than the device allows, or an argument
    /// belongs to another context.
    pub fn dispatch(&mut self, kernel: &'a Kernel, sets: &[&'a DescriptorSet], push: &[u8], groups: [u32; 3]) {
        self.check_dispatch(kernel, sets, push, groups);
        self.begin_label(kernel.name());
        self.time_dispatch(|timestamps, commands, place| timestamps.start_dispatch(commands, place));
        let (device, layout) = (self.device(), kernel.layout().raw());
        // SAFETY: invariants 1 and 3: all handles are alive until the submission is done; sets, push constants and
        // groups were checked against the pipeline's layout and the device's limits.
        unsafe {
            device.cmd_bind_pipeline(self.commands(), vk::PipelineBindPoint::COMPUTE, kernel.raw());
            for (place, set) in (0..).zip(sets).filter(|(_, set)| !set.shape().bindings.is_empty()) {
                let sets = [set.raw()];
                if kernel.source().sets.get(place as usize).is_some_and(|shape| !shape.bindings.is_empty()) {
                    let point = vk::PipelineBindPoint::COMPUTE;
                    device.cmd_bind_descriptor_sets(self.commands(), point, layout, place, &sets, &[]);
                }
            }
            if !push.is_empty() {
                device.cmd_push_constants(self.commands(), layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            }
            device.cmd_dispatch(self.commands(), groups[0], groups[1], groups[2]);
        }
        self.time_dispatch(|timestamps, commands, place| timestamps.stop_dispatch(commands, place));
        if let Some(dispatches) = &mut self.dispatches {
            dispatches.push(DispatchTime { kernel: kernel.name(), workgroups: groups, span: None });
        }
        self.end_label();
    }

    /// Makes everything that kernels and copies have written so far visible to the commands that follow.
    pub fn barrier(&mut self) {
        use vk::AccessFlags as Access;
        let kernels = Access::SHADER_READ | Access::SHADER_WRITE;
        self.memory_barrier(KERNEL_AND_COPY, kernels | Access::TRANSFER_READ | Access::TRANSFER_WRITE);
    }

    /// Fills a buffer with zeros.
    ///
    /// # Panics
    /// Where the buffer belongs to another context.
    pub fn fill_zero(&mut self, buffer: &'a Buffer) {
        self.check_context(buffer.context(), buffer.name());
        buffer.check_reachable();
        // SAFETY: invariants 1 and 3: the buffer is alive until the submission is done; its size is a multiple of 4.
        unsafe { self.device().cmd_fill_buffer(self.commands(), buffer.backing().raw(), 0, buffer.len_bytes(), 0) }
    }

    /// Copies bytes from one buffer to another.
    ///
    /// # Panics
    /// Where a range is outside its buffer, the two are the same buffer, or one belongs to another context.
    pub fn copy(&mut self, from: &'a Buffer, from_offset: u64, to: &'a Buffer, to_offset: u64, bytes: u64) {
        self.check_context(from.context(), from.name());
        self.check_context(to.context(), to.name());
        from.check_reachable();
        to.check_reachable();
        self.copy_backing(from.backing(), from_offset, to.backing(), to_offset, bytes);
    }

    pub(super) fn copy_backing(&mut self, from: &'a Backing, at: u64, to: &'a Backing, to_offset: u64, bytes: u64) {
        check_range(from.bytes(), at, bytes);
        check_range(to.bytes(), to_offset, bytes);
        assert!(from.raw() != to.raw(), "a buffer cannot be copied to itself");
        if bytes == 0 {
            return;
        }
        let region = [vk::BufferCopy { src_offset: at, dst_offset: to_offset, size: bytes }];
        // SAFETY: invariants 1 and 3: both buffers are alive until the submission is done; the ranges are inside them.
        unsafe { self.device().cmd_copy_buffer(self.commands(), from.raw(), to.raw(), &region) }
    }

    /// Builds an acceleration structure of one geometry, after all earlier writes and before all later reads.
    ///
    /// # Safety
    /// All that `info` names by handles and addresses lives until the submission is done, and is as large as the driver asked for.
    pub(super) unsafe fn build_structure(
        &mut self,
        structures: &khr::acceleration_structure::Device,
        info: &vk::AccelerationStructureBuildGeometryInfoKHR<'_>,
        count: u32,
    ) {
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)];
        let none = vk::DependencyFlags::empty();
        let build = vk::PipelineStageFlags::ACCELERATION_STRUCTURE_BUILD_KHR;
        let structure_accesses =
            vk::AccessFlags::ACCELERATION_STRUCTURE_READ_KHR | vk::AccessFlags::ACCELERATION_STRUCTURE_WRITE_KHR;
        let before = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE | vk::AccessFlags::ACCELERATION_STRUCTURE_WRITE_KHR)
            .dst_access_mask(structure_accesses | vk::AccessFlags::SHADER_READ)];
        let after = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::ACCELERATION_STRUCTURE_WRITE_KHR)
            .dst_access_mask(vk::AccessFlags::ACCELERATION_STRUCTURE_READ_KHR)];
        let readers = build | vk::PipelineStageFlags::COMPUTE_SHADER;
        let (device, commands) = (self.device(), self.commands());
        // SAFETY: invariant 1: the command buffer is owned by this recorder and being recorded; the rest is the caller's promise.
        unsafe {
            let writers = vk::PipelineStageFlags::TRANSFER | build;
            device.cmd_pipeline_barrier(commands, writers, build, none, &before, &[], &[]);
            structures.cmd_build_acceleration_structures(commands, &[*info], &[&range]);
            device.cmd_pipeline_barrier(commands, build, readers, none, &after, &[], &[]);
        }
    }

    fn memory_barrier(&mut self, stages: vk::PipelineStageFlags, accesses: vk::AccessFlags) {
        let barrier = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::SHADER_WRITE | vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(accesses)];
        let none = vk::DependencyFlags::empty();
        // SAFETY: invariant 1: the command buffer is owned by this recorder and being recorded.
        unsafe {
            self.device().cmd_pipeline_barrier(self.commands(), KERNEL_AND_COPY, stages, none, &barrier, &[], &[])
        }
    }

    fn check_dispatch(&self, kernel: &Kernel, sets: &[&DescriptorSet], push: &[u8], groups: [u32; 3]) {
        let (name, source) = (kernel.name(), kernel.source());
        self.check_context(kernel.context(), name);
        for (place, shape) in source.sets.iter().enumerate().filter(|(_, shape)| !shape.bindings.is_empty()) {
            let set = sets.get(place);
            assert!(set.is_some(), "the kernel `{name}` needs set {place}, but {} were given", sets.len());
            let fits = set.is_some_and(|set| shapes_match(set.shape().bindings, shape.bindings));
            assert!(fits, "set {place} does not fit the kernel `{name}`");
        }
        sets.iter().for_each(|set| self.check_context(set.context(), name));
        let (expected, given) = (source.push_constant_bytes as usize, push.len());
        assert!(expected == given, "`{name}` takes {expected} bytes of push constants, not {given}");
        let most = self.slot.context().device().limits.max_workgroup_count;
        let allowed = groups.iter().zip(most).all(|(&groups, most)| groups <= most);
        assert!(allowed, "{groups:?} workgroups of `{name}` are more than the device's {most:?}");
    }

    fn check_context(&self, context: &Arc<Context>, name: &str) {
        assert!(Arc::ptr_eq(context, self.slot.context()), "`{name}` belongs to another context than this submission");
    }

    /// Marks the begin or the end of the dispatch being recorded, where a record is kept.
    fn time_dispatch(&self, mark: impl FnOnce(&Timestamps<'_>, vk::CommandBuffer, usize)) {
        let timestamps = self.slot.timestamps().filter(|_| self.times_dispatches);
        if let (Some(timestamps), Some(dispatches)) = (timestamps, &self.dispatches) {
            mark(&timestamps, self.commands(), dispatches.len());
        }
    }

    fn begin_label(&self, name: &str) {
        let Some(debug) = self.slot.context().logical().debug() else { return };
        let name = c_name(name);
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: invariant 1: the command buffer is owned by this recorder and being recorded, and `label` is a local.
        unsafe { debug.cmd_begin_debug_utils_label(self.commands(), &label) }
    }

    fn end_label(&self) {
        let Some(debug) = self.slot.context().logical().debug() else { return };
        // SAFETY: invariant 1: the command buffer is owned by this recorder and being recorded, with a label open.
        unsafe { debug.cmd_end_debug_utils_label(self.commands()) }
    }

    fn commands(&self) -> vk::CommandBuffer {
        self.slot.commands()
    }

    fn device(&self) -> &ash::Device {
        self.slot.context().raw()
    }
}
