//! Ray queries: whether a device has them, and what opening it with them takes.

use std::ffi::CStr;

use ash::{khr, vk};

/// Extensions that ray queries need.
pub(super) const EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// Features that ray queries need.
#[derive(Default)]
pub(super) struct Features {
    structures: vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'static>,
    queries: vk::PhysicalDeviceRayQueryFeaturesKHR<'static>,
}

impl Features {
    /// The features, switched on.
    pub(super) fn enabled() -> Self {
        Self {
            structures: vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true),
            queries: vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true),
        }
    }

    /// Adds the features to those with which a device is opened.
    pub(super) fn add_to<'a>(&'a mut self, info: vk::DeviceCreateInfo<'a>) -> vk::DeviceCreateInfo<'a> {
        info.push_next(&mut self.structures).push_next(&mut self.queries)
    }
}

/// Limits of the device's acceleration structures; `None` where it has no ray queries. The device is of version 1.2 or later.
pub(super) fn properties(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
) -> Option<vk::PhysicalDeviceAccelerationStructurePropertiesKHR<'static>> {
    // A driver that cannot answer offers nothing.
    // SAFETY: invariant 1: `device` comes from the living `instance`.
    let offered = unsafe { instance.enumerate_device_extension_properties(device) }.ok()?;
    let is_offered = |name: &&CStr| offered.iter().any(|extension| extension.extension_name_as_c_str() == Ok(*name));
    if !EXTENSIONS.iter().all(is_offered) {
        return None;
    }
    let (mut own, mut vulkan12) = (Features::default(), vk::PhysicalDeviceVulkan12Features::default());
    let mut features = vk::PhysicalDeviceFeatures2::default()
        .push_next(&mut vulkan12)
        .push_next(&mut own.structures)
        .push_next(&mut own.queries);
    // SAFETY: invariant 1: `device` comes from the living `instance`, is of version 1.2 or later, and offers the extensions.
    unsafe { instance.get_physical_device_features2(device, &mut features) };
    let has = [vulkan12.buffer_device_address, own.structures.acceleration_structure, own.queries.ray_query];
    if has.contains(&vk::FALSE) {
        return None;
    }
    let mut structures = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut structures);
    // SAFETY: as above.
    unsafe { instance.get_physical_device_properties2(device, &mut properties) };
    Some(structures)
}
