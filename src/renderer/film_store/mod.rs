//! The film on the device, and what is read back from it.

pub(super) mod adaptive;
pub(super) mod pages;
pub(super) mod sums;
