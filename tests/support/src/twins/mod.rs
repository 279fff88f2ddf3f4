//! Slow, obvious twins of the pure GLSL functions, in double precision and under the same names. Tests compare the
//! kernels with them. Functions that production also calls are in [`lodestar::math`].

pub mod blue_noise;
pub mod camera;
pub mod coating;
pub mod conductor;
pub mod cosine;
pub mod cylindrical;
pub mod delta;
pub mod dielectric;
pub mod direction;
pub mod direction_map;
pub mod equal_area;
pub mod fresnel;
pub mod guide;
pub mod hashed;
pub mod intersect;
pub mod light;
pub mod microfacet;
pub mod normalization_entry;
pub mod phong;
pub mod plastic;
pub mod polarized_plastic;
pub mod principled;
pub mod principled_thin;
pub mod product;
pub mod program;
pub mod quadtree;
pub mod radiance_grid;
pub mod random;
pub mod rejection_mix;
pub mod relief;
pub mod rough_diffuse;
pub mod sobol;
pub mod texture;
pub mod voronoi;
pub mod ward;
