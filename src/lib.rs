//! Lodestar renders Mitsuba scenes with path guiding on any Vulkan device. It uses compute kernels only, no ray-tracing extension.
//! The method is "Fast and Lightweight Path Guiding Algorithm on GPU" (Kim and Kim, Pacific Graphics 2021), in an unbiased form.
//!
//! ```text
//!  scene.xml ─ scene/ ─▶ Scene ─ encode/ ─▶ words    CPU, no Vulkan, no unsafe
//!                                        │
//!                                      upload          renderer/: safe code over gpu/
//!    ┌── Renderer ──────────────────────────────────────────────────────────────────┐
//!    │ set 0  Frame              film pages, camera, materials, emitters, counters  │
//!    │ set 1  Bvh                wide BVH nodes, primitives, attributes             │
//!    │ set 2  RadianceGrid       what has been learned         L(cell, direction)   │
//!    │ set 3  NormalizationGrid  its memoized normalizers      N(cell, normal)      │
//!    │                                                                              │
//!    │ step(): trace ─▶ update_radiance ─▶ update_normalization                     │
//!    └──────────────────────────────────────────────────────────────────────────────┘
//!          │ read-back
//!        Picture ─▶ out.exr (layers) / out.png
//! ```
//!
//! To understand the algorithm read [`renderer::Renderer::step`], `glsl/kernels/trace/trace.comp` and
//! `glsl/include/path/vertex.glsl`.
//!
//! # A render in three lines
//! ```no_run
//! let picture = lodestar::render("scenes/furnace/scene.xml", &lodestar::Options::new().samples(64))?;
//! let rgb: &[[f32; 3]] = picture.rgb();
//! # Ok::<(), lodestar::Error>(())
//! ```
//! [`Session`] renders step by step, with a callback, from checkpoints and to files. [`Scene`] is read from a file or made in
//! code. `examples/` has one program for each of the three.
//!
//! # Code map
//! The table lists the modules from the highest to the lowest. A module may use modules below it, never one above it
//! (invariant 6).
//!
//! | module | content |
//! |---|---|
//! | [`reproduce`] | the paper's tables and figures, measured |
//! | [`session`] | a render from its start to its end, with checkpoints, safety copies, statistics and times |
//! | [`renderer`] | the paper in safe code, one file per descriptor set |
//! | [`film`] | the content of a pixel, and pictures made from parts |
//! | [`encode`] | conversion of a scene to the 32-bit words that kernels read: hierarchy, cells, lights, materials, textures, tables of cosines |
//! | [`settings`] | every choice of a user |
//! | [`scene`] | readers of scene files and meshes: world-space primitives, materials and emitters |
//! | [`gpu`] | Vulkan, and all of the crate's `unsafe`; nothing about rendering |
//! | [`math`] | functions that the product and its tests share: direction maps, Fresnel, microfacets, the sRGB curve |
//! | [`image`], [`files`] | EXR and PNG, error metrics, files written whole or not at all |
//! | [`spirv`] | tools that inspect, specialize and replace SPIR-V |
//! | [`generated`] | output of `build.rs` from `glsl/`: SPIR-V with its interface, constants, and checked struct layouts |
//!
//! # Paper map
//! | in the paper | GLSL | tests |
//! |---|---|---|
//! | radiance grid `L(x, w)`, Sec. 3 | `radiance_grid.glsl`, `grid_cell` in `cells.glsl` | `tests/proofs/claims/sums.rs` |
//! | equal-area and cylindrical directions | `map_to_sphere`, `sphere_to_map` in `direction_map.glsl` | `tests/samplers/direction_map.rs` |
//! | expected SARSA target, Eq. 5 | `target_expected_sarsa` in `expected_sarsa.glsl` | `tests/proofs/claims/targets.rs`, `tests/render/analytic.rs` (the learned field of a furnace) |
//! | SARSA target, Eq. 6 | `target_sarsa` in `learning.glsl` | `tests/proofs/claims/targets.rs`, `tests/render/analytic.rs` |
//! | Monte-Carlo target | `record_returns` in `monte_carlo.glsl` | `tests/proofs/claims/targets.rs`, `tests/render/analytic.rs` |
//! | update, Eq. 7 | `learn` in `update_radiance.comp` | `tests/proofs/claims/updates.rs` |
//! | queues of rays and a kernel for each kind of work, in place of one kernel (beyond the paper) | `wavefront.glsl`, `wave_extend.comp`, `wave_connect.comp`, `wave_shadow.comp`, `wave_shade.comp`, `wave_film.comp` | `tests/render/execution.rs` |
//! | cells that borrow from their parents (beyond the paper) | `pool_radiance.comp`, `blend_radiance.comp` | `tests/samplers/parents.rs` |
//! | normal-aware rejection, plain and mixed (Eq. 8, 9) | `sample_rejection_mix`, `pdf_rejection_mix` in `rejection_mix.glsl` | `tests/proofs/claims/samples.rs` (chi-square), `tests/proofs/claims/densities.rs`, `tests/render/ztest.rs` |
//! | inversion over the sphere | `sample_sphere_inversion`, `pdf_sphere_inversion` in `sphere_inversion.glsl`, `store_bin_ends` in `bin_distribution.glsl` | `tests/proofs/claims/samples.rs` (chi-square), `tests/proofs/claims/densities.rs`, `tests/render/ztest.rs` |
//! | inversion over the hemisphere | `sample_hemisphere_inversion`, `pdf_hemisphere_inversion` in `hemisphere_inversion.glsl` | `tests/proofs/claims/samples.rs` (chi-square), `tests/proofs/claims/densities.rs`, `tests/render/ztest.rs` |
//! | radiance times cosine, sampled exactly by a descent (beyond the paper) | `sample_product`, `pdf_product` in `product.glsl`, `product_record` in `radiance_tree.glsl` | `tests/proofs/claims/samples.rs` (chi-square), `tests/proofs/claims/densities.rs`, `tests/render/ztest.rs`, `tests/samplers/product.rs` |
//! | the quadtree with which the paper compares (Müller, Gross and Novák 2017) | `sample_quadtree`, `pdf_quadtree` in `quadtree.glsl`, `refine_quadtrees.comp` | `tests/samplers/quadtree.rs` (chi-square, trees compared with their twins), `tests/render/ztest.rs` |
//! | optimal mix, Eq. 8 | `optimal_uniform_share` in `normalization_entry.glsl` | `tests/samplers/normalization.rs` |
//! | scrambled Sobol sets of samples (beyond the paper) | `random_bits` and `camera_bits` in `random.glsl`, `sobol.glsl` | `tests/samplers/random.rs`, `tests/render/pattern.rs` |
//! | Sobol sets that the pixels of a tile share: blue noise (beyond the paper) | `tile_digits` in `blue_noise.glsl` | `tests/samplers/random.rs`, `tests/render/pattern.rs`, `tests/render/blue_noise.rs` |
//! | samples weighted by a schedule (beyond the paper) | `merge_radiance` in `tally.glsl`, [`film::weights`] | `tests/render/weights.rs` |
//! | adaptive sampling: noise estimated from two halves of the samples (beyond the paper) | `halves.glsl`, `judge_noise.comp`, [`film::noise`] | `tests/render/noise.rs` |
//! | emitter sampling, exact with every sampler | `sample_light` in `light.glsl`, `pdf_direction` in `guiding.glsl` | `tests/samplers/area_lights.rs`, `tests/samplers/environments.rs`, `tests/render/nee.rs` |
//! | memoized normalizer `N(x, n)` | `normalize_cell` in `normalization_entry.glsl`, `update_normalization.comp` | `tests/samplers/normalization.rs`, `tests/proofs/claims/entries.rs` |
//! | light-hit rate, Fig. 7a | `tally.glsl` | `tests/render/learning.rs` |
//! | displayed error (MAE), Table 1 | [`image::metrics`] | unit tests with independent numbers |
//!
//! # Invariants
//! 1. **Every sample is divided by the density with which it was drawn.** This density is positive wherever the surface can
//!    reflect. So the expectation of a picture does not depend on the guide's content.
//!    - Learned targets saturate: at 16 times the largest emitted radiance, or at 1024 times for Monte-Carlo returns, because
//!      Russian roulette divides these by survival probabilities. The inversion samplers draw light that the table lacks with
//!      little more than the least uniform share, and weight it by up to 2 / share at each edge. Both cost variance, never bias.
//!    - The weights of samples are fixed before the render. With [`film::noise`], which a user must ask for, the number of
//!      samples depends on their values, so the picture is consistent only.
//!    - The samples of a Sobol set depend on each other, but each one alone is uniform. No set extends over an update of the
//!      guide, so the guide of a sample was learned from other samples.
//! 2. **The same seed gives the same bits** on a device, however the picture is cut into dispatches or spread over threads.
//!    Random numbers are a hash of (pixel, sample, vertex, block, seed). One invocation takes all samples of a pixel in a
//!    dispatch. Learned sums are fixed-point integers.
//! 3. **Every loop is bounded.** The density accounts for the case that a loop reaches its bound. A loop that the driver cuts
//!    short is an error, never a dark pixel.
//! 4. **GLSL is the single source** of structs, constants, enum values, bindings and defaults of the kernels. Constants that both
//!    sides use are in `glsl/include/shared`. Rust takes them from there and is checked against GLSL when it compiles.
//!    The twins in `tests/support` repeat the numbers on purpose, because GLSL is checked against the twins.
//! 5. **A value that is used after a GLSL loop is carried by the loop**: it is set before the loop and read in it. Lavapipe of Mesa
//!    22.3 keeps no other value per lane.
//! 6. **Files and modules use each other in one direction.** No two files use each other, directly or through others, and
//!    neither do two modules of the code map. `scene`, `encode`, `math`, `image`, `film`, `settings`, `generated` and `spirv`
//!    never reach `gpu`; `gpu` never reaches `scene` or `renderer`. Only `gpu` names Vulkan (`ash`) and contains `unsafe`; only
//!    `image` names `exr`. A type that several files of a folder need is in a file below them, not in their `mod.rs`.
//!    `tests/hygiene` reads the imports of all files. It shows the chain of a breach file by file, and prints the layers
//!    with `--nocapture`.
//!
//! Deliberately absent: a render graph, bindless resources, traits with one implementation, options as strings past
//! [`settings`].
#![deny(missing_docs)]

use std::path::Path;

pub mod scene;
pub mod session;
pub mod settings;

// The hidden modules are for the command line, the tests and the benches. They are no public API and may change in any version.
#[doc(hidden)]
pub mod encode;
#[doc(hidden)]
pub mod error;
#[doc(hidden)]
pub mod files;
#[doc(hidden)]
pub mod film;
#[doc(hidden)]
pub mod generated;
#[doc(hidden)]
pub mod gpu;
#[doc(hidden)]
pub mod image;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod renderer;
#[doc(hidden)]
pub mod reproduce;
#[doc(hidden)]
pub mod spirv;

pub use error::{Error, Result};
pub use film::Picture;
pub use gpu::{Context, ContextOptions};
pub use scene::{Camera, Scene};
pub use session::{Options, Progress, Session};
pub use settings::Settings;

/// Renders a Mitsuba scene to a picture in memory.
///
/// ```no_run
/// let picture = lodestar::render("scene.xml", &lodestar::Options::new().samples(64))?;
/// # Ok::<(), lodestar::Error>(())
/// ```
///
/// # Errors
/// Where the scene cannot be read, an option does not suit it, no device can be used, or a result would be wrong.
pub fn render(scene: impl AsRef<Path>, options: &Options) -> Result<Picture> {
    let mut session = Session::open(scene, options)?;
    session.run(|_| std::ops::ControlFlow::Continue(()))?;
    session.picture()
}
