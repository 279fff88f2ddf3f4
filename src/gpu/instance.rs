//! Vulkan library and instance, with the validation layer where asked for.

use std::ffi::{CStr, c_char};

use ash::{ext, khr, vk};

use super::debug::{Messenger, ValidationLog, c_name};
use super::diagnosis::{NO_DRIVER, NO_LAYER, NO_LOADER, OLD_LOADER};
use super::fault::failed;
use super::fault_injection::{May, before};
use crate::{Error, Result};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Vulkan instance and the library that it came from.
pub(super) struct Instance {
    messenger: Option<Messenger>,
    raw: ash::Instance,
    /// Whether VK_EXT_debug_utils is enabled.
    has_debug_utils: bool,
    // Declared last: the instance calls into the library and writes to the log until it is destroyed.
    log: ValidationLog,
    _entry: ash::Entry,
}

impl Instance {
    pub(super) fn new(validate: bool) -> Result<Self> {
        // SAFETY: invariant 2 trusts the library that the system calls the Vulkan loader.
        let entry = unsafe { ash::Entry::load() }.map_err(|_| no_device(NO_LOADER))?;
        let offers = Offers::query(&entry, validate)?;
        let log = ValidationLog::default();
        let raw = create(&entry, &offers, validate.then_some(&log))?;
        let mut instance =
            Self { messenger: None, raw, has_debug_utils: offers.has(ext::debug_utils::NAME), log, _entry: entry };
        if validate && instance.has_debug_utils {
            let messenger = Messenger::new(&instance._entry, &instance.raw, &instance.log);
            instance.messenger = Some(messenger.map_err(failed("vkCreateDebugUtilsMessengerEXT"))?);
        }
        Ok(instance)
    }

    pub(super) fn raw(&self) -> &ash::Instance {
        &self.raw
    }

    pub(super) fn has_debug_utils(&self) -> bool {
        self.has_debug_utils
    }

    pub(super) fn log(&self) -> &ValidationLog {
        &self.log
    }

    /// All devices in the loader's order. A device's position is its index.
    pub(super) fn physical_devices(&self) -> Result<Vec<vk::PhysicalDevice>> {
        // SAFETY: invariant 1: the instance is alive.
        let devices = before(May::RunOutOfMemory)
            .and_then(|()| unsafe { self.raw.enumerate_physical_devices() })
            .map_err(no_driver_or("vkEnumeratePhysicalDevices"))?;
        if devices.is_empty() { Err(no_device(NO_DRIVER)) } else { Ok(devices) }
    }
}

/// Whether the Vulkan loader can be loaded.
pub(super) fn has_loader() -> bool {
    // SAFETY: invariant 2 trusts the library that the system calls the Vulkan loader. It is unloaded at once.
    unsafe { ash::Entry::load() }.is_ok()
}

/// Error of a machine without any device.
fn no_device(cause: &str) -> Error {
    Error::Device(format!("{cause}; `lodestar devices` says more"))
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.messenger = None;
        // SAFETY: invariants 1 and 2: owned by this value alone, and all its children held it and are gone.
        unsafe { self.raw.destroy_instance(None) }
    }
}

/// Extensions that loader, drivers and validation layer offer together.
struct Offers {
    extensions: Vec<vk::ExtensionProperties>,
}

impl Offers {
    fn query(entry: &ash::Entry, validate: bool) -> Result<Self> {
        require_version(entry)?;
        let mut extensions = extensions_of(entry, None)?;
        if validate {
            // SAFETY: invariant 2: the library is loaded and held.
            let layers = before(May::RunOutOfMemory)
                .and_then(|()| unsafe { entry.enumerate_instance_layer_properties() })
                .map_err(failed("vkEnumerateInstanceLayerProperties"))?;
            if !layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
                return Err(Error::Device(NO_LAYER.into()));
            }
            extensions.extend(extensions_of(entry, Some(VALIDATION_LAYER))?);
        }
        Ok(Self { extensions })
    }

    fn has(&self, name: &CStr) -> bool {
        self.extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
    }
}

fn extensions_of(entry: &ash::Entry, layer: Option<&CStr>) -> Result<Vec<vk::ExtensionProperties>> {
    // SAFETY: invariant 2: the library is loaded and held; the name ends in a zero.
    before(May::RunOutOfMemory)
        .and_then(|()| unsafe { entry.enumerate_instance_extension_properties(layer) })
        .map_err(no_driver_or("vkEnumerateInstanceExtensionProperties"))
}

fn require_version(entry: &ash::Entry) -> Result<()> {
    // SAFETY: invariant 2: the library is loaded and held.
    let version = unsafe { entry.try_enumerate_instance_version() }.map_err(failed("vkEnumerateInstanceVersion"))?;
    match version {
        Some(version) if version >= vk::API_VERSION_1_2 => Ok(()),
        _ => Err(Error::Device(OLD_LOADER.into())),
    }
}

/// Turns the codes of a missing driver into an error that says so. Loaders answer ERROR_INCOMPATIBLE_DRIVER, some
/// ERROR_INITIALIZATION_FAILED.
fn no_driver_or(call: &'static str) -> impl FnOnce(vk::Result) -> Error {
    move |code| match code {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER | vk::Result::ERROR_INITIALIZATION_FAILED => no_device(NO_DRIVER),
        other => failed(call)(other),
    }
}

/// Creates the instance. With a log, the validation layer is enabled.
fn create(entry: &ash::Entry, offers: &Offers, log: Option<&ValidationLog>) -> Result<ash::Instance> {
    let name = c_name(env!("CARGO_PKG_NAME"));
    let application = vk::ApplicationInfo::default().application_name(&name).api_version(vk::API_VERSION_1_2);
    let wanted = [ext::debug_utils::NAME, khr::portability_enumeration::NAME, ext::validation_features::NAME];
    let extensions: Vec<*const c_char> = wanted.into_iter().filter(|name| offers.has(name)).map(CStr::as_ptr).collect();
    let layers = [VALIDATION_LAYER.as_ptr()];
    let mut info =
        vk::InstanceCreateInfo::default().application_info(&application).enabled_extension_names(&extensions);
    if offers.has(khr::portability_enumeration::NAME) {
        info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
    }
    // Reports missing barriers, except between two kernels that both write: they may write to different places.
    let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
    let mut messenger = log.map(ValidationLog::messenger_info);
    if log.is_some() {
        info = info.enabled_layer_names(&layers);
        if offers.has(ext::validation_features::NAME) {
            info = info.push_next(&mut features);
        }
    }
    if let Some(messenger) = messenger.as_mut().filter(|_| offers.has(ext::debug_utils::NAME)) {
        info = info.push_next(messenger);
    }
    // SAFETY: invariant 1: all that `info` points to are locals; the log outlives the instance.
    before(May::RunOutOfMemory)
        .and_then(|()| unsafe { entry.create_instance(&info, None) })
        .map_err(no_driver_or("vkCreateInstance"))
}
