//! The kernel registry that `build.rs` writes: SPIR-V with its interface, specialization constants, shared enum values.

use crate::gpu::{BindingKind, BindingShape, KernelSource, SetShape};

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
