//! Readers of plugins: from a description to a [`Scene`](super::Scene). Parameters and defaults are Mitsuba's.

mod color;
mod color_blocks;
mod curves;
mod cylinder;
mod emission;
mod emitter_plugin;
mod fit;
mod flatten;
mod integrator;
pub mod load;
mod materials;
mod media;
pub(in crate::scene) mod names;
mod parameter;
mod programs;
mod projector;
mod properties;
mod role;
mod scope;
mod sensor;
mod shape;
mod sunsky;
mod texture_images;
mod texture_parameters;
mod textures;
mod transform;
mod vertex_colors;
