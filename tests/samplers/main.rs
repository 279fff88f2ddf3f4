//! Pure functions of the kernels on the device. Samplers are tested against their own densities, and all functions
//! against their twins on the CPU. Every statistical test has a fixed seed, so that it always passes or always fails,
//! and a twin with a planted fault that must fail.

mod area_lights;
mod blender_nodes;
mod bsdf;
mod camera;
mod direction_map;
mod directions;
mod environments;
mod film;
mod fixture;
mod guides;
mod instances;
mod intersections;
mod light_selection;
mod lights;
mod looked_up;
mod measured;
mod normalization;
mod parametrization;
mod parents;
mod phase;
mod principled;
mod product;
mod programs;
mod quadtree;
mod query_geometry;
mod random;
mod ray_queries;
mod relief;
mod scattering;
mod shares;
mod statistics;
mod surfaces;
mod textures;
mod twins;
