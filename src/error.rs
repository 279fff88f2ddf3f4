//! The one error type. Every variant prints as one sentence that names the thing at fault and what to do about it.

use std::path::{Path, PathBuf};

/// What can go wrong, from a scene file to a lost device.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene file or a mesh it names is malformed or asks for something unsupported.
    #[error("{}{}: {message}", file.display(), line_suffix(*line))]
    Scene {
        /// The file at fault.
        file: PathBuf,
        /// Its line, counted from 1, where one can be named.
        line: Option<u32>,
        /// What is wrong and what to do.
        message: String,
    },
    /// A file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file could not be written; nothing of it is left behind.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// An image file is malformed or of a kind that is not supported.
    #[error("{}: {message}", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        message: String,
    },
    /// A checkpoint is damaged, or another version's.
    #[error("{}: {message}", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        message: String,
    },
    /// A kernel's SPIR-V cannot be read, or cannot stand in for the built-in one.
    #[error("{}: {message}", path.display())]
    Kernel {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        message: String,
    },
    /// A setting is out of its range, or two settings contradict each other.
    #[error("{0}")]
    Settings(String),
    /// No usable Vulkan device, or the one asked for is refused.
    #[error("{0}")]
    Device(String),
    /// A Vulkan call failed.
    #[error("{call} failed: {reason}")]
    Vulkan {
        /// The call, or the kernel that was running.
        call: String,
        /// The driver's answer in words.
        reason: String,
    },
    /// The device was lost, and with it all that was only there.
    #[error(
        "{call} failed: the device was lost (a fault in the driver, or a watchdog ended work that took too long){note}"
    )]
    DeviceLost {
        /// The call, or the kernel that was running.
        call: String,
        /// What else is to be said, after a semicolon; nothing at first.
        note: String,
    },
    /// The device has no more memory.
    #[error("{call} failed: out of device memory{note}")]
    OutOfDeviceMemory {
        /// The call, or the kernel that was to run.
        call: String,
        /// What else is to be said, after a semicolon; nothing at first.
        note: String,
    },
    /// A result would be wrong: a loop ran out of its budget, say.
    #[error("{0}")]
    Render(String),
}

/// The crate's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An [`Error::Scene`].
    pub fn scene(file: impl AsRef<Path>, line: Option<u32>, message: impl Into<String>) -> Self {
        Self::Scene { file: file.as_ref().to_path_buf(), line, message: message.into() }
    }

    /// An [`Error::Read`], for `map_err`.
    pub fn read(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Read { path: path.as_ref().to_path_buf(), source }
    }

    /// An [`Error::Write`], for `map_err`.
    pub fn write(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Write { path: path.as_ref().to_path_buf(), source }
    }

    /// An [`Error::Kernel`].
    pub fn kernel(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::Kernel { path: path.as_ref().to_path_buf(), message: message.into() }
    }

    /// An [`Error::Image`].
    pub fn image(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::Image { path: path.as_ref().to_path_buf(), message: message.into() }
    }

    /// A fault of the device with a clause more.
    #[must_use]
    pub fn noting(mut self, clause: &str) -> Self {
        if let Self::DeviceLost { note, .. } | Self::OutOfDeviceMemory { note, .. } = &mut self {
            note.push_str("; ");
            note.push_str(clause);
        }
        self
    }

    /// A fault of the device with the work that the call belonged to.
    #[must_use]
    pub fn during(mut self, work: &str) -> Self {
        if let Self::DeviceLost { call, .. } | Self::OutOfDeviceMemory { call, .. } = &mut self {
            *call = format!("{work}: {call}");
        }
        self
    }

    /// An [`Error::Checkpoint`].
    pub fn checkpoint(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::Checkpoint { path: path.as_ref().to_path_buf(), message: message.into() }
    }
}

fn line_suffix(line: Option<u32>) -> String {
    line.map(|line| format!(":{line}")).unwrap_or_default()
}
