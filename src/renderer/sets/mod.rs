//! The descriptor sets, one file each, of the same name as the GLSL file that declares the set's bindings.

pub(super) mod bvh;
pub(super) mod frame;
pub(super) mod normalization_grid;
pub(super) mod radiance_grid;
