//! SPIR-V as data: inspected by engineers, specialized before a driver sees it, and replaced by edited kernels.

pub mod inspect;
mod module;
pub mod replace;
pub(crate) mod specialization;
pub(crate) mod tools;
