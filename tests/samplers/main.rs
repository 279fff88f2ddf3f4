//! The pure functions of the kernels on the device: samplers against their own densities, all against their twins on the
//! host. Every statistical test has a fixed seed, so it passes always or never, and a tampered twin that it must reject.

mod area_lights;
mod bsdf;
mod camera;
mod direction_map;
mod directions;
mod environments;
mod fixture;
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
mod scattering;
mod shares;
mod statistics;
mod surfaces;
mod textures;
mod twins;
