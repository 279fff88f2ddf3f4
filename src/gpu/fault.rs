//! Errors of Vulkan calls, in words.

use ash::vk;

use crate::Error;

/// Turns a failed call's code into an error that names the call; for `map_err`.
pub(super) fn failed(call: impl Into<String>) -> impl FnOnce(vk::Result) -> Error {
    move |code| {
        let (call, note) = (call.into(), String::new());
        match code {
            vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost { call, note },
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => Error::OutOfDeviceMemory { call, note },
            code => Error::Vulkan { call, reason: reason(code) },
        }
    }
}

fn reason(code: vk::Result) -> String {
    match code {
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => "out of host memory".into(),
        vk::Result::ERROR_INITIALIZATION_FAILED => "the driver could not be initialized".into(),
        other => format!("the driver answered {other:?}"),
    }
}
