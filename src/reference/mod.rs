//! Slow, obvious twins of the pure GLSL functions, in double precision and under the same names. Tests hold the kernels
//! against them.

pub mod camera;
pub mod cosine;
pub mod cylindrical;
pub mod direction;
pub mod direction_map;
pub mod equal_area;
pub mod guide;
pub mod intersect;
pub mod normalization_entry;
pub mod radiance_grid;
pub mod random;
pub mod rejection_mix;
