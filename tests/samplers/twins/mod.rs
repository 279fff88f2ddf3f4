//! The twins themselves, against what is known of them on paper.

mod blue_noise;
mod direction_map;
mod microfacet;
mod product;
mod quadtree;
mod random;
