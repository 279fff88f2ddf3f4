//! Scenes as a path tracer needs them: read from files of several formats and flattened. CPU only: no Vulkan, no `unsafe`.
//!
//! Conventions are Mitsuba's. The world is right-handed. The texture coordinate `v` is 0 at the image's *top* row. The
//! camera looks along its `+z`, with `+x` to the *left* of the picture. Depth is counted in path edges (1 is emission
//! seen directly).

pub mod bsdf;
mod build;
mod camera;
mod color_matching;
mod convert;
pub mod deformation;
mod description;
pub mod emitter;
mod faults;
mod film;
pub mod fingerprint;
mod folders;
mod foreign;
mod formats;
pub mod geometry;
mod gltf;
mod grids;
mod inflate;
mod integrator;
mod load_options;
pub mod measured;
pub mod medium;
mod mesh;
mod mitsuba;
pub mod motion;
mod numbers;
pub mod objects;
pub mod parameter;
mod pbrt;
mod place;
mod plugins;
mod principled;
pub mod program;
mod read;
mod shrink;
mod spectrum;
pub mod summary;
mod tensor_file;
pub mod texel_pages;
mod text;
pub mod texture;
pub mod texture_lookup;
mod usd;
mod whole;

pub use bsdf::{Bsdf, Material, MaterialKind, SurfaceMaterial};
pub use build::Surface;
pub use camera::{Camera, FovAxis, Projection};
pub use convert::{Converted, convert, convert_dictionary};
pub use description::transform::{Operation, Transform};
pub use emitter::{AreaEmitter, Cone, DeltaEmitter, DeltaKind, Environment, EnvironmentKind, PictureAxes};
pub use film::{Crop, FilmDescription, ReconstructionFilter, Window};
pub use fingerprint::fingerprint;
pub use formats::format_names;
pub use geometry::{Group, Instance, Primitive, PrimitiveShape};
pub use integrator::IntegratorDescription;
pub use load_options::{CameraChoice, EnvironmentChoice, LoadOptions};
pub use medium::{AlbedoVolume, Boundary, Media, Medium, Phase, PhaseLobe, Volume, VolumeWrap, Volumes};
pub use mitsuba::dictionary::{Array, Dictionary, Value};
pub use motion::{Course, Motion};
pub use place::scene_file;
pub(crate) use plugins::kept_meshes::KeptMeshes;
pub use plugins::load::{LoadProgress, scene_name};
pub(crate) use read::load_keeping;
pub use read::{load, load_with_progress};
pub use texture::{Image, Texture, Textured};
pub use whole::Scene;
