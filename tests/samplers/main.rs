//! The pure functions of the kernels on the device: samplers against their own densities, all against their twins on the
//! host. Every statistical test has a fixed seed, so it passes always or never, and a tampered twin that it must reject.

mod area_lights;
mod bsdf;
mod camera;
mod device;
mod direction_map;
mod directions;
mod environments;
mod fixture;
// `tests/proofs` uses all of it.
#[allow(dead_code)]
mod guide_cases;
mod guides;
mod intersections;
mod lights;
mod normalization;
mod parametrization;
mod parents;
mod principled;
mod product;
mod quadtree;
mod random;
mod relief;
mod sampled_directions;
mod scattering;
mod scattering_cases;
mod shares;
mod statistics;
mod substances;
mod surfaces;
mod textures;
