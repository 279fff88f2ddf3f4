//! Messages from the validation layer, and names of Vulkan objects for messages and debuggers.

use std::ffi::{CStr, CString, c_void};
use std::fmt::Write;
use std::sync::{Arc, Mutex, PoisonError};

use ash::{ext, vk};

/// Most messages kept, so that a mistake in a loop does not fill the memory.
const LOG_CAPACITY: usize = 1000;

/// Log of the validation layer's messages. The handle may outlive its context, so that leaks reported at the very end
/// are seen too.
#[derive(Clone, Default)]
pub struct ValidationLog(Arc<Mutex<Vec<String>>>);

impl ValidationLog {
    /// Warnings and errors so far, in order.
    pub fn messages(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Description of a messenger that writes to this log. The log must outlive the messenger.
    pub(super) fn messenger_info(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            .message_type(Type::GENERAL | Type::VALIDATION | Type::PERFORMANCE)
            .pfn_user_callback(Some(receive))
            .user_data(Arc::as_ptr(&self.0).cast_mut().cast())
    }
}

/// Receives a message. The layer calls this function from any thread while a Vulkan call is under way. Messages of type
/// GENERAL alone are the loader's remarks about drivers that it tried; they are no fault of ours and go to the trace.
unsafe extern "system" fn receive(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: invariant 1: `user_data` is the log's mutex, owned by the instance and freed after it.
    let log = unsafe { user_data.cast::<Mutex<Vec<String>>>().as_ref() };
    // SAFETY: invariant 1: a valid structure, for the duration of the callback.
    let data = unsafe { data.as_ref() };
    let (Some(log), Some(data)) = (log, data) else { return vk::FALSE };
    let message = describe(data);
    if types == vk::DebugUtilsMessageTypeFlagsEXT::GENERAL {
        tracing::debug!("{message}");
        return vk::FALSE;
    }
    let mut messages = log.lock().unwrap_or_else(PoisonError::into_inner);
    if messages.len() < LOG_CAPACITY {
        messages.push(message);
    }
    vk::FALSE
}

/// Text of a message, with the names of objects that it does not mention itself.
fn describe(data: &vk::DebugUtilsMessengerCallbackDataEXT<'_>) -> String {
    let mut message = text(data.p_message).unwrap_or_default();
    if data.p_objects.is_null() {
        return message;
    }
    // SAFETY: invariant 1: `object_count` valid objects, for the duration of the callback.
    let objects = unsafe { std::slice::from_raw_parts(data.p_objects, data.object_count as usize) };
    for name in objects.iter().filter_map(|object| text(object.p_object_name)) {
        if !message.contains(&name) {
            // Writing to a String does not fail.
            let _ = write!(message, " [{name}]");
        }
    }
    message
}

fn text(chars: *const std::ffi::c_char) -> Option<String> {
    if chars.is_null() {
        return None;
    }
    // SAFETY: invariant 1: a string that ends in a zero, valid for the duration of the callback.
    Some(unsafe { CStr::from_ptr(chars) }.to_string_lossy().into_owned())
}

/// Messenger of the validation layer. The instance keeps the log, which outlives the messenger.
pub(super) struct Messenger {
    api: ext::debug_utils::Instance,
    raw: vk::DebugUtilsMessengerEXT,
}

impl Messenger {
    /// Makes the messenger, which must be dropped before `instance` is destroyed.
    pub(super) fn new(entry: &ash::Entry, instance: &ash::Instance, log: &ValidationLog) -> Result<Self, vk::Result> {
        let api = ext::debug_utils::Instance::new(entry, instance);
        // SAFETY: invariant 1: the caller's instance is alive and has the extension enabled; the log outlives it.
        let raw = unsafe { api.create_debug_utils_messenger(&log.messenger_info(), None)? };
        Ok(Self { api, raw })
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: invariants 1 and 2: owned by this value alone, and the instance is destroyed later.
        unsafe { self.api.destroy_debug_utils_messenger(self.raw, None) }
    }
}

/// Name as a C string; anything after a zero byte is cut off.
pub(super) fn c_name(name: &str) -> CString {
    let until_zero = name.split('\0').next().unwrap_or_default();
    CString::new(until_zero).unwrap_or_default()
}
