//! Injected faults, for tests of what survives a fault. Only this file reads the environment variable `LODESTAR_FAULT`.
//!
//! With `lost@N`, the N-th Vulkan call that may lose the device loses it, and all later calls find it lost. With
//! `memory@N`, the N-th call that may run out of device memory does so, once. N counts from 1 and covers every call
//! that can fail in this way, including those of the memory allocator. Calls in the device's function table are
//! replaced; calls of the instance and of extensions ask [`before`] first.

use std::ffi::c_void;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;

/// Environment variable that says which fault occurs, and when.
const VARIABLE: &str = "LODESTAR_FAULT";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    Lost,
    Memory,
}

/// Faults with which a call may answer, by the Vulkan specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum May {
    RunOutOfMemory,
    DoBoth,
}

struct Plan {
    fault: Fault,
    at: u64,
    calls: AtomicU64,
}

impl Plan {
    fn parse(text: &str) -> Option<Self> {
        let (fault, at) = text.split_once('@')?;
        let fault = match fault {
            "lost" => Fault::Lost,
            "memory" => Fault::Memory,
            _ => return None,
        };
        Some(Self { fault, at: at.parse().ok()?, calls: AtomicU64::new(0) })
    }

    /// Fault with which the next call answers; `None` where the call runs normally.
    fn next(&self, may: May) -> Option<vk::Result> {
        if self.fault == Fault::Lost && may == May::RunOutOfMemory {
            return None;
        }
        let call = self.calls.fetch_add(1, Ordering::Relaxed) + 1;
        match self.fault {
            Fault::Lost => (call >= self.at).then_some(vk::Result::ERROR_DEVICE_LOST),
            Fault::Memory => (call == self.at).then_some(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY),
        }
    }
}

fn plan() -> Option<&'static Plan> {
    static PLAN: OnceLock<Option<Plan>> = OnceLock::new();
    PLAN.get_or_init(|| Plan::parse(&std::env::var(VARIABLE).ok()?)).as_ref()
}

/// Fault with which a call outside the device's table answers; `Ok` where the call runs normally.
pub(super) fn before(may: May) -> Result<(), vk::Result> {
    plan().and_then(|plan| plan.next(may)).map_or(Ok(()), Err)
}

/// Replaces the device's functions by ones that fail as planned. Without a plan the device is returned unchanged.
pub(super) fn wrap(device: ash::Device) -> ash::Device {
    if plan().is_none() {
        return device;
    }
    let mut calls = device.fp_v1_0().clone();
    // One driver only: a process that tests faults opens one device.
    let _ = DRIVERS.set(calls.clone());
    replace(&mut calls);
    let (calls_1_1, calls_1_2, calls_1_3) = (device.fp_v1_1(), device.fp_v1_2(), device.fp_v1_3());
    ash::Device::from_parts_1_3(device.handle(), calls, calls_1_1.clone(), calls_1_2.clone(), calls_1_3.clone())
}

/// The driver's own functions.
static DRIVERS: OnceLock<ash::DeviceFnV1_0> = OnceLock::new();

/// Asks the plan, then the driver.
fn answer(may: May, call: impl FnOnce(&ash::DeviceFnV1_0) -> vk::Result) -> vk::Result {
    match (before(may), DRIVERS.get()) {
        (Ok(()), Some(driver)) => call(driver),
        (Err(code), _) => code,
        // No function of the table is called before a device was wrapped.
        (Ok(()), None) => vk::Result::ERROR_INITIALIZATION_FAILED,
    }
}

macro_rules! hooks {
    ($($may:ident $name:ident($($argument:ident: $type:ty),*);)*) => {
        $(unsafe extern "system" fn $name($($argument: $type),*) -> vk::Result {
            // SAFETY: invariant 1: called in place of the driver, with the arguments that the driver would have got.
            answer(May::$may, |driver| unsafe { (driver.$name)($($argument),*) })
        })*

        fn replace(calls: &mut ash::DeviceFnV1_0) {
            $(calls.$name = $name;)*
            calls.wait_for_fences = wait_for_fences;
        }
    };
}

type Allocator<'a> = *const vk::AllocationCallbacks<'a>;

hooks! {
    RunOutOfMemory allocate_memory(device: vk::Device, info: *const vk::MemoryAllocateInfo<'_>, callbacks: Allocator<'_>, memory: *mut vk::DeviceMemory);
    RunOutOfMemory map_memory(device: vk::Device, memory: vk::DeviceMemory, offset: u64, size: u64, flags: vk::MemoryMapFlags, data: *mut *mut c_void);
    RunOutOfMemory flush_mapped_memory_ranges(device: vk::Device, count: u32, ranges: *const vk::MappedMemoryRange<'_>);
    RunOutOfMemory invalidate_mapped_memory_ranges(device: vk::Device, count: u32, ranges: *const vk::MappedMemoryRange<'_>);
    RunOutOfMemory create_buffer(device: vk::Device, info: *const vk::BufferCreateInfo<'_>, callbacks: Allocator<'_>, buffer: *mut vk::Buffer);
    RunOutOfMemory bind_buffer_memory(device: vk::Device, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: u64);
    RunOutOfMemory create_buffer_view(device: vk::Device, info: *const vk::BufferViewCreateInfo<'_>, callbacks: Allocator<'_>, view: *mut vk::BufferView);
    RunOutOfMemory create_shader_module(device: vk::Device, info: *const vk::ShaderModuleCreateInfo<'_>, callbacks: Allocator<'_>, module: *mut vk::ShaderModule);
    RunOutOfMemory create_pipeline_cache(device: vk::Device, info: *const vk::PipelineCacheCreateInfo<'_>, callbacks: Allocator<'_>, cache: *mut vk::PipelineCache);
    RunOutOfMemory get_pipeline_cache_data(device: vk::Device, cache: vk::PipelineCache, size: *mut usize, data: *mut c_void);
    RunOutOfMemory create_compute_pipelines(device: vk::Device, cache: vk::PipelineCache, count: u32, infos: *const vk::ComputePipelineCreateInfo<'_>, callbacks: Allocator<'_>, pipelines: *mut vk::Pipeline);
    RunOutOfMemory create_pipeline_layout(device: vk::Device, info: *const vk::PipelineLayoutCreateInfo<'_>, callbacks: Allocator<'_>, layout: *mut vk::PipelineLayout);
    RunOutOfMemory create_descriptor_set_layout(device: vk::Device, info: *const vk::DescriptorSetLayoutCreateInfo<'_>, callbacks: Allocator<'_>, layout: *mut vk::DescriptorSetLayout);
    RunOutOfMemory create_descriptor_pool(device: vk::Device, info: *const vk::DescriptorPoolCreateInfo<'_>, callbacks: Allocator<'_>, pool: *mut vk::DescriptorPool);
    RunOutOfMemory allocate_descriptor_sets(device: vk::Device, info: *const vk::DescriptorSetAllocateInfo<'_>, sets: *mut vk::DescriptorSet);
    RunOutOfMemory create_fence(device: vk::Device, info: *const vk::FenceCreateInfo<'_>, callbacks: Allocator<'_>, fence: *mut vk::Fence);
    RunOutOfMemory create_command_pool(device: vk::Device, info: *const vk::CommandPoolCreateInfo<'_>, callbacks: Allocator<'_>, pool: *mut vk::CommandPool);
    RunOutOfMemory allocate_command_buffers(device: vk::Device, info: *const vk::CommandBufferAllocateInfo<'_>, buffers: *mut vk::CommandBuffer);
    RunOutOfMemory begin_command_buffer(buffer: vk::CommandBuffer, info: *const vk::CommandBufferBeginInfo<'_>);
    RunOutOfMemory reset_command_pool(device: vk::Device, pool: vk::CommandPool, flags: vk::CommandPoolResetFlags);
    RunOutOfMemory reset_fences(device: vk::Device, count: u32, fences: *const vk::Fence);
    RunOutOfMemory end_command_buffer(buffer: vk::CommandBuffer);
    RunOutOfMemory create_query_pool(device: vk::Device, info: *const vk::QueryPoolCreateInfo<'_>, callbacks: Allocator<'_>, pool: *mut vk::QueryPool);
    DoBoth queue_submit(queue: vk::Queue, count: u32, submits: *const vk::SubmitInfo<'_>, fence: vk::Fence);
    DoBoth get_query_pool_results(device: vk::Device, pool: vk::QueryPool, first: u32, count: u32, size: usize, data: *mut c_void, stride: u64, flags: vk::QueryResultFlags);
}

/// Waits for the driver even where the plan reports a lost device: in truth the device goes on working, and it must
/// finish before its buffers are freed.
unsafe extern "system" fn wait_for_fences(
    device: vk::Device,
    count: u32,
    fences: *const vk::Fence,
    all: vk::Bool32,
    timeout: u64,
) -> vk::Result {
    // SAFETY: invariant 1: called in place of the driver, with the arguments that the driver would have got.
    let wait = |driver: &ash::DeviceFnV1_0| unsafe { (driver.wait_for_fences)(device, count, fences, all, timeout) };
    match before(May::DoBoth) {
        Err(vk::Result::ERROR_DEVICE_LOST) => {
            DRIVERS.get().map(wait);
            vk::Result::ERROR_DEVICE_LOST
        }
        Err(code) => code,
        Ok(()) => DRIVERS.get().map_or(vk::Result::ERROR_INITIALIZATION_FAILED, wait),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_stays_lost_and_memory_runs_out_once() {
        let lost = Plan::parse("lost@2").expect("a plan");
        let answers = [May::DoBoth, May::RunOutOfMemory, May::DoBoth, May::DoBoth].map(|may| lost.next(may));
        let code = Some(vk::Result::ERROR_DEVICE_LOST);
        assert_eq!(answers, [None, None, code, code]);
        let memory = Plan::parse("memory@2").expect("a plan");
        let answers = [May::DoBoth, May::RunOutOfMemory, May::DoBoth].map(|may| memory.next(may));
        assert_eq!(answers, [None, Some(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY), None]);
        assert!(["", "lost", "lost@", "lost@-1", "fire@1"].iter().all(|text| Plan::parse(text).is_none()));
    }
}
