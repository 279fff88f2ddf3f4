//! Twins themselves, tested against results that are known on paper.

mod blue_noise;
mod direction_map;
mod microfacet;
mod product;
mod quadtree;
mod random;
