//! The command `lodestar`.

use std::ffi::OsString;
use std::process::ExitCode;

use pyo3::prelude::*;

use crate::shared::detached;

/// Runs the command line with these arguments, of which the first is the program's name. Returns the exit code.
#[pyfunction]
pub fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    let code = detached(py, || lodestar::cli::run(arguments))?;
    Ok((0..=u8::MAX).find(|&number| ExitCode::from(number) == code).unwrap_or(1))
}
