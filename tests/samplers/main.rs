//! The pure functions of the kernels on the device: samplers against their own densities, all against their twins on the
//! host. Every statistical test has a fixed seed, so it passes always or never, and a tampered twin that it must reject.

mod camera;
mod device;
mod direction_map;
mod directions;
mod fixed_point;
mod guide_cases;
mod guides;
mod intersections;
mod learning;
mod normalization;
mod parametrization;
mod random;
mod statistics;
mod surfaces;
