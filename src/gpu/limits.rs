//! Limits of a device, as plain data.

use ash::vk;
use serde::Serialize;

/// Limits of a device.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Limits {
    /// Largest storage buffer, in bytes.
    pub max_storage_buffer_bytes: u64,
    /// Largest texel buffer, in texels of 16 bytes.
    pub max_texel_elements: u64,
    /// Largest single allocation, in bytes.
    pub max_allocation_bytes: u64,
    /// Most invocations in a workgroup.
    pub max_workgroup_invocations: u32,
    /// Most workgroups of a dispatch, along each axis.
    pub max_workgroup_count: [u32; 3],
    /// Most bytes of shared memory in a workgroup.
    pub max_shared_bytes: u32,
    /// Most storage buffers that a kernel may bind.
    pub max_storage_buffers: u32,
    /// Most texel buffers that a kernel may bind.
    pub max_texel_buffers: u32,
    /// Most descriptor sets that a kernel may bind.
    pub max_bound_sets: u32,
    /// Most bytes of push constants.
    pub max_push_constant_bytes: u32,
    /// Number of invocations that run in lockstep.
    pub subgroup_size: u32,
    /// Whether a kernel can ask which invocations of its subgroup are active.
    pub has_subgroup_ballot: bool,
    /// Whether kernels can let the device traverse acceleration structures (VK_KHR_ray_query).
    pub has_ray_queries: bool,
    /// Most elements of one part of an acceleration structure.
    pub max_structure_elements: u64,
    /// Unit in bytes to which the address of an acceleration structure's scratch memory is rounded.
    pub scratch_alignment: u32,
    /// Bytes of device-local memory. Drivers on the CPU may report less than there is.
    pub device_local_bytes: u64,
    /// Unit in bytes to which host reads and writes of incoherent memory are rounded.
    pub non_coherent_atom_bytes: u64,
    /// Nanoseconds per tick of the device's clock.
    pub timestamp_nanoseconds: f32,
}

impl Limits {
    /// Limits that every version of Vulkan reports.
    pub(super) fn from_core(limits: &vk::PhysicalDeviceLimits) -> Self {
        Self {
            max_storage_buffer_bytes: limits.max_storage_buffer_range.into(),
            max_texel_elements: limits.max_texel_buffer_elements.into(),
            // The least that Vulkan guarantees; replaced by the driver's answer where there is one.
            max_allocation_bytes: 1 << 30,
            max_workgroup_invocations: limits.max_compute_work_group_invocations,
            max_workgroup_count: limits.max_compute_work_group_count,
            max_shared_bytes: limits.max_compute_shared_memory_size,
            max_storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
            max_texel_buffers: limits.max_per_stage_descriptor_sampled_images,
            max_bound_sets: limits.max_bound_descriptor_sets,
            max_push_constant_bytes: limits.max_push_constants_size,
            subgroup_size: 0,
            has_subgroup_ballot: false,
            has_ray_queries: false,
            max_structure_elements: 0,
            scratch_alignment: 1,
            device_local_bytes: 0,
            non_coherent_atom_bytes: limits.non_coherent_atom_size,
            timestamp_nanoseconds: limits.timestamp_period,
        }
    }
}
