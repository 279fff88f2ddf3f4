//! Mitsuba's scene format: XML of any version to a [`Scene`](super::Scene).

mod color;
mod color_blocks;
mod color_matching;
pub mod convert;
pub mod dictionary;
mod document;
mod element;
mod emitter_plugin;
mod faults;
mod fit;
mod flatten;
mod folders;
mod integrator;
pub mod load;
mod materials;
mod numbers;
mod old_files;
mod plugins;
mod properties;
mod scope;
mod sensor;
mod shape;
mod spectrum;
mod texture_images;
mod textures;
mod transform;
mod vertex_colors;
