//! Identity and limits of a device, as plain data.

use std::ffi::CStr;

use ash::vk;
use serde::Serialize;

use super::limits::Limits;
use super::needs::{self, Capabilities, version_text};
use super::ray_queries;

/// Kinds of device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DeviceKind {
    /// GPU with memory of its own.
    Discrete,
    /// GPU that shares the host's memory.
    Integrated,
    /// GPU passed to a virtual machine.
    Virtual,
    /// The CPU, through a software driver.
    Cpu,
    /// Any other kind.
    Other,
}

/// Description of a device, with the reason where it cannot be used.
#[derive(Debug, Clone, Serialize)]
pub struct DeviceInfo {
    /// Index in the list of devices.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// Kind of the device.
    pub kind: DeviceKind,
    /// Vulkan version that the device offers, such as `1.3.230`.
    pub api_version: String,
    /// Name of the driver.
    pub driver_name: String,
    /// The driver's description of itself, which contains its version in words.
    pub driver_info: String,
    /// The vendor's PCI id, or Khronos' number for a vendor without one.
    pub vendor_id: u32,
    /// The vendor's number for this device.
    pub device_id: u32,
    /// Version of the driver, in the vendor's own encoding.
    pub driver_version: u32,
    /// Identifier of the pipelines that this driver can read back; hexadecimal.
    pub pipeline_cache_uuid: String,
    /// Limits of the device.
    pub limits: Limits,
    /// Needs that the device lacks, as a clause; `None` where it can be used.
    pub refused: Option<String>,
}

impl DeviceInfo {
    /// Asks the driver.
    pub(super) fn query(instance: &ash::Instance, device: vk::PhysicalDevice, index: usize) -> Self {
        // SAFETY: invariant 1: `device` comes from the living `instance`.
        let properties = unsafe { instance.get_physical_device_properties(device) };
        let mut info = Self::from_core(&properties, index);
        let mut capabilities = Capabilities {
            api_version: properties.api_version,
            has_compute_queue: compute_queue(instance, device).is_some(),
            has_scalar_block_layout: false,
        };
        info.limits.device_local_bytes = device_local_bytes(instance, device);
        // The structures below belong to Vulkan 1.2; an older device is refused anyway.
        if properties.api_version >= vk::API_VERSION_1_2 {
            info.add_details(instance, device);
            capabilities.has_scalar_block_layout = has_scalar_block_layout(instance, device);
            if let Some(structures) = ray_queries::properties(instance, device) {
                info.limits.has_ray_queries = true;
                info.limits.max_structure_elements = structures.max_primitive_count;
                info.limits.scratch_alignment = structures.min_acceleration_structure_scratch_offset_alignment.max(1);
            }
        }
        info.refused = needs::lacking(&capabilities, &info.limits);
        info
    }

    fn from_core(properties: &vk::PhysicalDeviceProperties, index: usize) -> Self {
        let version = properties.api_version;
        Self {
            index,
            name: string(properties.device_name_as_c_str().ok()),
            kind: kind(properties.device_type),
            api_version: version_text(version),
            driver_name: String::new(),
            driver_info: String::new(),
            vendor_id: properties.vendor_id,
            device_id: properties.device_id,
            driver_version: properties.driver_version,
            pipeline_cache_uuid: hex(&properties.pipeline_cache_uuid),
            limits: Limits::from_core(&properties.limits),
            refused: None,
        }
    }

    /// Adds the properties that only Vulkan 1.2 reports: driver, subgroups and the largest allocation.
    fn add_details(&mut self, instance: &ash::Instance, device: vk::PhysicalDevice) {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut maintenance = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut driver)
            .push_next(&mut subgroup)
            .push_next(&mut maintenance);
        // SAFETY: invariant 1: `device` comes from the living `instance`, and is of version 1.2 or later.
        unsafe { instance.get_physical_device_properties2(device, &mut properties) };
        self.limits.subgroup_size = subgroup.subgroup_size;
        self.limits.has_subgroup_ballot = subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
            && subgroup.supported_operations.contains(vk::SubgroupFeatureFlags::BALLOT);
        self.limits.max_allocation_bytes = maintenance.max_memory_allocation_size;
        self.driver_name = string(driver.driver_name_as_c_str().ok());
        self.driver_info = string(driver.driver_info_as_c_str().ok());
    }
}

/// Queue family for compute, and the number of valid bits in its timestamps. The first family with timestamps is
/// preferred; without one, the first compute family is taken.
pub(super) fn compute_queue(instance: &ash::Instance, device: vk::PhysicalDevice) -> Option<(u32, u32)> {
    // SAFETY: invariant 1: `device` comes from the living `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let able =
        || (0..).zip(&families).filter(|(_, f)| f.queue_count > 0 && f.queue_flags.contains(vk::QueueFlags::COMPUTE));
    let family = able().find(|(_, f)| f.timestamp_valid_bits > 0).or_else(|| able().next());
    family.map(|(index, f)| (index, f.timestamp_valid_bits))
}

fn has_scalar_block_layout(instance: &ash::Instance, device: vk::PhysicalDevice) -> bool {
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12);
    // SAFETY: invariant 1: `device` comes from the living `instance`, and is of version 1.2 or later.
    unsafe { instance.get_physical_device_features2(device, &mut features) };
    vulkan12.scalar_block_layout == vk::TRUE
}

fn device_local_bytes(instance: &ash::Instance, device: vk::PhysicalDevice) -> u64 {
    // SAFETY: invariant 1: `device` comes from the living `instance`.
    let memory = unsafe { instance.get_physical_device_memory_properties(device) };
    let heaps = memory.memory_heaps_as_slice().iter();
    heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL)).map(|heap| heap.size).sum()
}

fn kind(kind: vk::PhysicalDeviceType) -> DeviceKind {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    }
}

fn string(chars: Option<&CStr>) -> String {
    chars.map(|chars| chars.to_string_lossy().into_owned()).unwrap_or_default()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
