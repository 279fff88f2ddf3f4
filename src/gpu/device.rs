//! The opened device and its queue.

use std::ffi::{CStr, c_char};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::{ext, khr, vk};

use super::debug::c_name;
use super::device_info::{DeviceInfo, compute_queue};
use super::fault::failed;
use super::fault_injection::{self, May};
use super::instance::Instance;
use super::ray_queries;
use crate::{Error, Result};

/// Device opened for compute.
pub(super) struct LogicalDevice {
    raw: ash::Device,
    debug: Option<ext::debug_utils::Device>,
    executables: Option<khr::pipeline_executable_properties::Device>,
    structures: Option<khr::acceleration_structure::Device>,
    physical: vk::PhysicalDevice,
    queue: Mutex<vk::Queue>,
    queue_family: u32,
    timestamp_bits: u32,
    info: DeviceInfo,
    // Declared last, because the device must be destroyed first.
    instance: Instance,
}

impl LogicalDevice {
    pub(super) fn new(instance: Instance, physical: vk::PhysicalDevice, mut info: DeviceInfo) -> Result<Self> {
        let (queue_family, timestamp_bits) = compute_queue(instance.raw(), physical)
            .ok_or_else(|| Error::Device(format!("the Vulkan device {} has no compute queue", info.name)))?;
        let opened = open(&instance, physical, queue_family, info.limits.has_ray_queries);
        let (raw, tells_executables) = match opened {
            // A driver that fails with ray queries may still render without them.
            Err(Error::Vulkan { reason, .. }) if info.limits.has_ray_queries => {
                tracing::warn!("{} does not open with ray queries ({reason}), so it is opened without", info.name);
                info.limits.has_ray_queries = false;
                open(&instance, physical, queue_family, false)?
            }
            opened => opened?,
        };
        let has_ray_queries = info.limits.has_ray_queries;
        let debug = instance.has_debug_utils().then(|| ext::debug_utils::Device::new(instance.raw(), &raw));
        let executables =
            tells_executables.then(|| khr::pipeline_executable_properties::Device::new(instance.raw(), &raw));
        let structures = has_ray_queries.then(|| khr::acceleration_structure::Device::new(instance.raw(), &raw));
        // SAFETY: invariant 1: the device was just created with one queue of this family.
        let queue = unsafe { raw.get_device_queue(queue_family, 0) };
        let queue = Mutex::new(queue);
        Ok(Self { raw, debug, executables, structures, physical, queue, queue_family, timestamp_bits, info, instance })
    }

    pub(super) fn raw(&self) -> &ash::Device {
        &self.raw
    }

    pub(super) fn physical(&self) -> vk::PhysicalDevice {
        self.physical
    }

    pub(super) fn instance(&self) -> &Instance {
        &self.instance
    }

    pub(super) fn info(&self) -> &DeviceInfo {
        &self.info
    }

    pub(super) fn queue_family(&self) -> u32 {
        self.queue_family
    }

    /// Number of valid bits in a timestamp; 0 where the queue takes no timestamps.
    pub(super) fn timestamp_bits(&self) -> u32 {
        self.timestamp_bits
    }

    /// The queue, idle. The holder of this guard has sole access to the device's memory (invariant 3).
    pub(super) fn idle_queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Functions of VK_EXT_debug_utils, where it is enabled.
    pub(super) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.debug.as_ref()
    }

    /// Functions of VK_KHR_pipeline_executable_properties, where the driver has it.
    pub(super) fn executables(&self) -> Option<&khr::pipeline_executable_properties::Device> {
        self.executables.as_ref()
    }

    /// Functions of VK_KHR_acceleration_structure, where the device has ray queries.
    pub(super) fn structures(&self) -> Option<&khr::acceleration_structure::Device> {
        self.structures.as_ref()
    }

    /// Names an object of this device for messages and debuggers.
    pub(super) fn name(&self, handle: impl vk::Handle, name: &str) {
        let Some(debug) = &self.debug else { return };
        let name = c_name(name);
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // A missing name does no harm, so failures are ignored.
        // SAFETY: invariant 1: the caller passes a living handle of this device that no other thread has yet seen.
        let _ = fault_injection::before(May::RunOutOfMemory)
            .and_then(|()| unsafe { debug.set_debug_utils_object_name(&info) });
    }
}

impl Drop for LogicalDevice {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 2: owned by this value alone, all its children held it and are gone; invariant 3:
        // nothing runs.
        unsafe { self.raw.destroy_device(None) }
    }
}

/// Opens the device. The flag says whether the driver reports on the executables of a pipeline.
fn open(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    has_ray_queries: bool,
) -> Result<(ash::Device, bool)> {
    // SAFETY: invariant 1: `physical` comes from the living instance.
    let offered = fault_injection::before(May::RunOutOfMemory)
        .and_then(|()| unsafe { instance.raw().enumerate_device_extension_properties(physical) })
        .map_err(failed("vkEnumerateDeviceExtensionProperties"))?;
    // Devices that implement Vulkan on top of another interface require this extension to be enabled.
    let subset = khr::portability_subset::NAME;
    let is_offered = |name: &CStr| offered.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name));
    let executables = khr::pipeline_executable_properties::NAME;
    let tells_executables = is_offered(executables) && has_executable_info(instance, physical);
    let wanted = [(subset, is_offered(subset)), (executables, tells_executables)];
    let wanted = wanted.into_iter().chain(ray_queries::EXTENSIONS.map(|name| (name, has_ray_queries)));
    let extensions: Vec<*const c_char> =
        wanted.filter(|(_, is_wanted)| *is_wanted).map(|(name, _)| name.as_ptr()).collect();
    // SAFETY: invariant 1: `physical` comes from the living instance.
    let supported = unsafe { instance.raw().get_physical_device_features(physical) };
    let features =
        vk::PhysicalDeviceFeatures::default().robust_buffer_access(supported.robust_buffer_access == vk::TRUE);
    let mut vulkan12 =
        vk::PhysicalDeviceVulkan12Features::default().scalar_block_layout(true).buffer_device_address(has_ray_queries);
    let mut ray_query_features = ray_queries::Features::enabled();
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let mut executable_info =
        vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .enabled_features(&features)
        .push_next(&mut vulkan12);
    if tells_executables {
        info = info.push_next(&mut executable_info);
    }
    if has_ray_queries {
        info = ray_query_features.add_to(info);
    }
    // SAFETY: invariant 1: `physical` comes from the living instance, and all that `info` points to are locals.
    let device = fault_injection::before(May::DoBoth)
        .and_then(|()| unsafe { instance.raw().create_device(physical, &info, None) })
        .map_err(failed("vkCreateDevice"))?;
    Ok((fault_injection::wrap(device), tells_executables))
}

/// Whether the driver has the feature `pipelineExecutableInfo`. Call it only where the extension
/// VK_KHR_pipeline_executable_properties is offered.
fn has_executable_info(instance: &Instance, physical: vk::PhysicalDevice) -> bool {
    let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut executables);
    // SAFETY: invariant 1: `physical` comes from the living instance, and is of version 1.2 or later: it was not
    // refused.
    unsafe { instance.raw().get_physical_device_features2(physical, &mut features) };
    executables.pipeline_executable_info == vk::TRUE
}
