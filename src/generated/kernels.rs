//! Kernel registry, written by `build.rs`: the SPIR-V of each kernel and its interface.

use std::borrow::Cow;

use strum::{EnumMessage, IntoStaticStr, VariantArray};

use super::interface::{BindingKind, BindingShape, KernelSource, SetShape};

pub use super::constants::*;

include!(concat!(env!("OUT_DIR"), "/registry.rs"));

/// What kernels read geometry and tables from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, EnumMessage, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum BackEnd {
    /// Texel buffers, where the device allows them to be as large as a scene needs.
    Texel,
    /// Storage buffers.
    Storage,
    /// Storage buffers, and for rays an acceleration structure that the device traverses (`--traversal query`).
    Query,
}

impl BackEnd {
    /// All back ends.
    pub const ALL: [Self; 3] = [Self::Texel, Self::Storage, Self::Query];
}

/// Kernels of all back ends. A render uses one of them.
#[derive(Debug, Clone)]
pub struct Registry {
    /// Kernels that read texel buffers.
    pub texel: Kernels,
    /// Kernels that read storage buffers.
    pub storage: Kernels,
    /// Kernels that traverse an acceleration structure.
    pub query: Kernels,
}

impl Registry {
    /// Kernels as compiled with this crate.
    pub fn built_in() -> Self {
        Self { texel: TEXEL_BUFFERS.clone(), storage: STORAGE_BUFFERS.clone(), query: RAY_QUERIES.clone() }
    }

    /// Kernels of one back end.
    pub fn kernels(&self, back_end: BackEnd) -> &Kernels {
        match back_end {
            BackEnd::Texel => &self.texel,
            BackEnd::Storage => &self.storage,
            BackEnd::Query => &self.query,
        }
    }

    /// Kernels of all back ends, to replace some of them.
    pub fn all_mut(&mut self) -> [&mut Kernels; 3] {
        [&mut self.texel, &mut self.storage, &mut self.query]
    }
}
