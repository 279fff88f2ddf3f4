//! Kernel registry, written by `build.rs`: the SPIR-V of each kernel and its interface.

use std::borrow::Cow;

use super::interface::{BindingKind, BindingShape, KernelSource, SetShape};

pub use super::constants::*;

include!(concat!(env!("OUT_DIR"), "/registry.rs"));

/// Kind of buffer from which kernels read geometry and tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum BackEnd {
    /// Texel buffers, where the device allows them to be as large as a scene needs.
    Texel,
    /// Storage buffers.
    Storage,
}

/// Kernels of both back ends. A render uses one of the two.
#[derive(Debug, Clone)]
pub struct Registry {
    /// Kernels that read texel buffers.
    pub texel: Kernels,
    /// Kernels that read storage buffers.
    pub storage: Kernels,
}

impl Registry {
    /// Kernels as compiled with this crate.
    pub fn built_in() -> Self {
        Self { texel: TEXEL_BUFFERS.clone(), storage: STORAGE_BUFFERS.clone() }
    }

    /// Kernels of one back end.
    pub fn kernels(&self, back_end: BackEnd) -> &Kernels {
        match back_end {
            BackEnd::Texel => &self.texel,
            BackEnd::Storage => &self.storage,
        }
    }
}
