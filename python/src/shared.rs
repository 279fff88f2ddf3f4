//! Functions that several classes use.

use lodestar::settings::Settings;
use pyo3::prelude::*;

use crate::errors::refused;

/// Numbers and words of the library as Python's dictionaries and lists.
pub fn from_json(py: Python<'_>, value: &impl serde::Serialize) -> PyResult<Py<PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| refused(error.to_string()))?;
    Ok(py.import("json")?.call_method1("loads", (text,))?.unbind())
}

/// Settings by name, as the headers of pictures have them.
pub fn settings_of(py: Python<'_>, settings: &Settings) -> PyResult<Py<PyAny>> {
    from_json(py, settings)
}
