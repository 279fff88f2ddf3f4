//! The Vulkan devices of this machine.

use lodestar::gpu::{DeviceInfo, survey};
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::errors::refused;
use crate::shared::{detached, from_json};

/// The Vulkan devices of this machine, one dictionary each: `index`, `name`, `kind`, `driver_name`, `limits` and more. `default`
/// says whether the device renders if none is chosen, and `refused` what keeps it from use, or None.
///
/// Raises
/// ------
/// lodestar.Error
///     Where there is no device. The message says what to do, as `lodestar devices` does.
#[pyfunction]
pub fn devices(py: Python<'_>) -> PyResult<Py<PyAny>> {
    let wanted = std::env::var("LODESTAR_DEVICE").ok().filter(|device| !device.trim().is_empty());
    let found = detached(py, || survey(wanted.as_deref()))?;
    if found.devices.is_empty() {
        return Err(refused(found.advice.join("; ")));
    }
    let list = PyList::empty(py);
    for device in &found.devices {
        let DeviceInfo { index, .. } = device;
        let entry = from_json(py, device)?;
        entry.bind(py).set_item("default", found.default == Some(*index))?;
        list.append(entry)?;
    }
    Ok(list.into_any().unbind())
}
