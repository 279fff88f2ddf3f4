//! The crate's error type. Every variant prints as one sentence that names the thing at fault and what to do about it.

use std::path::{Path, PathBuf};

/// Everything that can go wrong, from a scene file to a lost device.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene file, or a mesh that it names, is malformed or uses an unsupported feature.
    #[error("{}{}: {}", one_line(file.display()), line_suffix(*line), one_line(message))]
    Scene {
        /// The file at fault.
        file: PathBuf,
        /// The line at fault, counted from 1, where one is known.
        line: Option<u32>,
        /// The fault and its remedy.
        message: String,
    },
    /// A scene cannot be rendered, for several reasons.
    #[error("the scene has {} faults:{}", .0.len(), listed(.0))]
    Several(Vec<Error>),
    /// A file could not be read.
    #[error("{}: cannot be read: {source}", one_line(path.display()))]
    Read {
        /// The file.
        path: PathBuf,
        /// The error that the system reported.
        source: std::io::Error,
    },
    /// A file could not be written. No part of it is left on the disk.
    #[error("{}: cannot be written: {source}", one_line(path.display()))]
    Write {
        /// The file.
        path: PathBuf,
        /// The error that the system reported.
        source: std::io::Error,
    },
    /// An image file is malformed or of a kind that is not supported.
    #[error("{}: {}", one_line(path.display()), one_line(message))]
    Image {
        /// The file.
        path: PathBuf,
        /// The fault and its remedy.
        message: String,
    },
    /// A checkpoint is damaged or was written by another version.
    #[error("{}: {}", one_line(path.display()), one_line(message))]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// The fault and its remedy.
        message: String,
    },
    /// A kernel's SPIR-V cannot be read or cannot replace the built-in kernel.
    #[error("{}: {}", one_line(path.display()), one_line(message))]
    Kernel {
        /// The file.
        path: PathBuf,
        /// The fault and its remedy.
        message: String,
    },
    /// A setting is out of its range, or two settings contradict each other.
    #[error("{0}")]
    Settings(String),
    /// No usable Vulkan device was found, or the device asked for is refused.
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
    /// The device was lost together with all data that was only in its memory.
    #[error(
        "{call} failed: the device was lost (a fault in the driver, or a watchdog ended work that took too long){note}"
    )]
    DeviceLost {
        /// The call, or the kernel that was running.
        call: String,
        /// Further clauses, each after a semicolon; empty at first.
        note: String,
    },
    /// A rank of a render has ended or does not answer, and its part of the data is lost.
    #[error("{rank} does not answer any more{note}")]
    RankLost {
        /// The rank and its machine.
        rank: String,
        /// Further clauses, each after a semicolon; empty at first.
        note: String,
    },
    /// The device has no memory left.
    #[error("{call} failed: out of device memory{note}")]
    OutOfDeviceMemory {
        /// The call, or the kernel that was to run.
        call: String,
        /// Further clauses, each after a semicolon; empty at first.
        note: String,
    },
    /// A result would be wrong.
    #[error("{0}")]
    Render(String),
    /// The driver ended a loop of a kernel early, so that a result would be wrong.
    #[error("{0}")]
    LoopCut(String),
}

/// Result with this crate's [`Error`] by default.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Makes an [`Error::Scene`].
    pub fn scene(file: impl AsRef<Path>, line: Option<u32>, message: impl Into<String>) -> Self {
        Self::Scene { file: file.as_ref().to_path_buf(), line, message: message.into() }
    }

    /// Makes an [`Error::Read`]; for `map_err`.
    pub fn read(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Read { path: path.as_ref().to_path_buf(), source }
    }

    /// Makes an [`Error::Write`]; for `map_err`.
    pub fn write(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Write { path: path.as_ref().to_path_buf(), source }
    }

    /// Makes an [`Error::Kernel`].
    pub fn kernel(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::Kernel { path: path.as_ref().to_path_buf(), message: message.into() }
    }

    /// Makes an [`Error::Image`].
    pub fn image(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::Image { path: path.as_ref().to_path_buf(), message: message.into() }
    }

    /// Whether a device or a rank was lost, and with it data that was nowhere else.
    pub fn is_loss(&self) -> bool {
        matches!(self, Self::DeviceLost { .. } | Self::RankLost { .. })
    }

    /// Adds a clause to the message of a lost device or rank, or of lacking device memory. Other errors stay as they are.
    #[must_use]
    pub fn noting(mut self, clause: &str) -> Self {
        if let Self::DeviceLost { note, .. } | Self::RankLost { note, .. } | Self::OutOfDeviceMemory { note, .. } =
            &mut self
        {
            note.push_str("; ");
            note.push_str(clause);
        }
        self
    }

    /// Names the work that the failed call belonged to, for a lost device or lacking device memory. Other errors stay
    /// as they are.
    #[must_use]
    pub fn during(mut self, work: &str) -> Self {
        if let Self::DeviceLost { call, .. } | Self::OutOfDeviceMemory { call, .. } = &mut self {
            *call = format!("{work}: {call}");
        }
        self
    }

    /// Makes an [`Error::Checkpoint`].
    pub fn checkpoint(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::Checkpoint { path: path.as_ref().to_path_buf(), message: message.into() }
    }
}

/// Most faults that one message lists.
const MOST_LISTED: usize = 50;

/// Errors on a line each.
fn listed(errors: &[Error]) -> String {
    let mut text: String = errors.iter().take(MOST_LISTED).map(|error| format!("\n  {error}")).collect();
    if errors.len() > MOST_LISTED {
        text += &format!("\n  and {} more", errors.len() - MOST_LISTED);
    }
    text
}

/// A text in one line: what a terminal would take for orders becomes a blank. Names in a scene may hold any character.
fn one_line(text: impl std::fmt::Display) -> String {
    text.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn line_suffix(line: Option<u32>) -> String {
    line.map(|line| format!(":{line}")).unwrap_or_default()
}

#[test]
fn messages_give_no_orders() {
    let error = Error::scene("a\nb.xml", Some(3), "no\u{1b}[2J \u{9b}plugin\nlodestar: error: forged");
    assert_eq!(error.to_string(), "a b.xml:3: no [2J  plugin lodestar: error: forged");
}
