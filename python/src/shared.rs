//! Functions that several classes use.

use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use lodestar::settings::Settings;
use pyo3::prelude::*;

use crate::errors::refused;

/// Number of the process in which the library first did something; 0 before that.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Does work of the library, while other threads of Python run.
///
/// # Errors
/// In a process that was forked from one in which the library has worked. The threads of its drivers are not in the child, so the work
/// would wait for ever.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    if is_forked() {
        let message = "this process was forked from one that has used lodestar already, and its device cannot be used here; call \
                       `multiprocessing.set_start_method(\"spawn\")` first, or use lodestar in the child processes only";
        return Err(refused(message));
    }
    Ok(py.detach(work))
}

/// Whether this process was forked from one in which the library has worked.
pub fn is_forked() -> bool {
    let own = process::id();
    let first = PROCESS.compare_exchange(0, own, Ordering::Relaxed, Ordering::Relaxed);
    first.is_err_and(|first| first != own)
}

/// Numbers and words of the library as Python's dictionaries and lists.
pub fn from_json(py: Python<'_>, value: &impl serde::Serialize) -> PyResult<Py<PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| refused(error.to_string()))?;
    Ok(py.import("json")?.call_method1("loads", (text,))?.unbind())
}

/// Settings by name, as the headers of pictures have them.
pub fn settings_of(py: Python<'_>, settings: &Settings) -> PyResult<Py<PyAny>> {
    from_json(py, settings)
}
