//! The kernel registry that `build.rs` writes: SPIR-V with its interface.

use std::borrow::Cow;

use super::interface::{BindingKind, BindingShape, KernelSource, SetShape};

pub use super::constants::*;

include!(concat!(env!("OUT_DIR"), "/registry.rs"));

/// Where kernels read geometry and tables from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum BackEnd {
    /// Texel buffers, where the device allows them to be as large as a scene needs.
    Texel,
    /// Storage buffers.
    Storage,
}

/// The kernels of both back ends, of which a render takes one.
#[derive(Debug, Clone)]
pub struct Registry {
    /// Those that read texel buffers.
    pub texel: Kernels,
    /// Those that read storage buffers.
    pub storage: Kernels,
}

impl Registry {
    /// The kernels as they were compiled with this crate.
    pub fn built_in() -> Self {
        Self { texel: TEXEL_BUFFERS.clone(), storage: STORAGE_BUFFERS.clone() }
    }

    /// The kernels of one back end.
    pub fn kernels(&self, back_end: BackEnd) -> &Kernels {
        match back_end {
            BackEnd::Texel => &self.texel,
            BackEnd::Storage => &self.storage,
        }
    }
}
