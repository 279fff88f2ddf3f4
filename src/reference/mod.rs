//! Slow, obvious twins of the pure GLSL functions, in double precision and under the same names. Tests hold the kernels
//! against them.

pub mod camera;
pub mod cosine;
pub mod direction;
pub mod equal_area;
pub mod intersect;
pub mod normalization_entry;
pub mod radiance_grid;
pub mod random;
pub mod rejection_mix;
pub mod texture;
