//! Functions that production and tests share, in double precision: maps between squares and the sphere, reflection at smooth
//! and rough surfaces, noise, the sRGB curve. No function depends on scenes, files or devices.
//!
//! Directions are unit vectors in the frame that the function names. Twins of GLSL functions that only tests need are in the
//! crate `tests/support`.

pub mod cylindrical;
pub mod direction_map;
pub mod equal_area;
pub mod fresnel;
pub mod microfacet;
pub mod perlin;
pub mod srgb;
