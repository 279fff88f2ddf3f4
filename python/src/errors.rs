//! Errors and warnings of the library, as Python raises them.

use std::ffi::CString;

use lodestar::gpu::survey;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyUserWarning};
use pyo3::prelude::*;

create_exception!(
    lodestar,
    Error,
    PyException,
    "Everything that can go wrong: a scene that cannot be read, a setting that is out of its range, a lost device.\n\n\
     The message is one sentence that names the thing at fault and what to do, as the command line prints it."
);

/// The exception for an error of the library. Where no device was found, its message is that of `lodestar devices`.
pub fn raised(error: lodestar::Error) -> PyErr {
    let message = match error {
        lodestar::Error::Device(message) => {
            let found = survey(None);
            if found.devices.is_empty() { found.advice.join("; ") } else { message }
        }
        other => other.to_string(),
    };
    Error::new_err(message)
}

/// The exception with this message.
pub fn refused(message: impl Into<String>) -> PyErr {
    Error::new_err(message.into())
}

/// Shows warnings as Python does: a user may silence them, or turn them into errors.
pub fn warn(py: Python<'_>, messages: &[String]) -> PyResult<()> {
    let category = py.get_type::<PyUserWarning>();
    messages.iter().try_for_each(|message| {
        // A text of the library holds no zero byte, unless a file's name does.
        let text = CString::new(message.replace('\0', " ")).unwrap_or_default();
        PyErr::warn(py, &category, &text, 1)
    })
}
