//! Encoding of a [`Scene`](crate::scene::Scene) as the words that kernels read. CPU only: no Vulkan, no `unsafe`.

pub mod bvh;
pub mod cells;
pub mod cosine_integrals;
pub mod cosine_trees;
pub mod lights;
pub(crate) mod materials;
pub mod measured;
pub mod media;
pub mod plastic_layer;
pub(crate) mod plastics;
pub mod query_geometry;
pub mod sheen;
pub mod surfaces;
pub mod textures;
pub(crate) mod volumes;
