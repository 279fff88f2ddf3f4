//! Slow, obvious twins of the pure GLSL functions, in double precision and under the same names. Tests hold the kernels
//! against them.

pub mod equal_area;
