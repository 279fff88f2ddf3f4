//! Kernels of the renderer with a mutation of `tests/tampered`.

use std::borrow::Cow;
use std::sync::Arc;

use lodestar::encode::bvh::Bvh;
use lodestar::encode::surfaces::Surfaces;
use lodestar::generated::kernels::Registry;
use lodestar::gpu::{Context, KernelSource};
use lodestar::renderer::Renderer;
use lodestar::scene::Scene;
use lodestar::settings::Settings;

/// Mutations: factors on the densities that samples are divided by.
pub const DENSITIES: &str = "densities 5 % off";
pub const DENSITIES_FAR: &str = "densities 25 % off";
/// Mutations: factors on the reflectance that learning uses.
pub const BRIGHTER: &str = "learning takes surfaces to be 5 % brighter";
pub const TWICE_AS_BRIGHT: &str = "learning takes surfaces to be twice as bright";
/// Mutations: faults of the weights of emitter sampling.
pub const BLIND_TO_GUIDE: &str = "weights blind to the guide";
pub const COUNTED_TWICE: &str = "light counted whole however it is found";
/// Mutations: faults of light that goes straight on through surfaces.
pub const SHUT: &str = "holes that shadow rays do not pass";
pub const PASSED_TWICE: &str = "light that passes each surface twice";
pub const WRONG_VERTEX: &str = "the density at the last hole";
/// Mutations: faults of light that is refracted on its way to a surface that scatters it.
pub const NOT_WEAKENED: &str = "light that refraction does not weaken";
pub const REFRACTED_TWICE: &str = "refracted light counted twice";
pub const WRONG_DIRECTION: &str = "the density of a refracted direction";
pub const STRAIGHT_SHADES: &str = "refracted rays blocked by what lies on their straight line";
/// Mutation: behind a hole, a disk faces the hole in place of the surface that it lights.
pub const TURNED_TO_HOLE: &str = "facing disks turned to the last hole";
/// Mutations: faults of media.
pub const DIMMED_TWICE: &str = "media that dim sampled lights twice";
pub const OTHER_SIDE: &str = "the medium of the other side";
pub const OTHER_PHASE: &str = "in media, the density of another phase function";
/// Mutations: faults of media that are grids.
pub const GRID_DIMMED_TWICE: &str = "grids that dim sampled lights twice";
pub const LOW_MAJORANTS: &str = "majorants too low";
pub const UNWEIGHTED_NULL: &str = "null collisions without a weight";
/// Mutation: bump maps that are computed have slopes of the wrong sign.
pub const TILTED_BACK: &str = "computed heights tilt to the wrong side";
/// Mutations: faults of instances.
pub const INSTANCE_FAULTS: [&str; 3] = [
    "an instance turns normals like directions",
    "an instance turns normals of vertices like directions",
    "rays of unit length in instances",
];
/// Mutations: faults of motion.
pub const MOTION_FAULTS: [&str; 2] = ["motions turn the other way", "a lamp sampled at another time"];
/// Mutations: faults of meshes that deform.
pub const DEFORMING_FAULTS: [&str; 2] =
    ["normals of a deforming mesh at the key before", "a deforming mesh goes back between its keys"];
/// Mutation: shadow rays follow 16 surfaces in place of 1024 edges.
pub const FEW_SURFACES: &str = "shadow rays through few surfaces";
/// Mutation: shadow rays end 0.09 % before a light, as those of Mitsuba 3 do. What stands between lets light through.
pub const SHORT_OF_LIGHT: &str = "shadow rays end before the light";
/// Mutation: rays start as far off a surface as those of Mitsuba 3 do. What is closer to the surface lets light through.
pub const FAR_OFF: &str = "rays start far off";

/// Built-in kernel with the mutation.
pub fn kernel(built_in: &KernelSource, mutation: &str) -> KernelSource {
    let mut source = built_in.clone();
    source.spirv = Cow::Owned(tampered::kernel(built_in.name, mutation));
    source
}

/// Registry of kernels. With a mutation, every kernel that reads storage buffers has it.
pub fn registry(mutation: Option<&str>) -> Registry {
    let mut registry = Registry::built_in();
    if let Some(mutation) = mutation {
        registry.storage.iter_mut().for_each(|built_in| *built_in = kernel(built_in, mutation));
    }
    registry
}

/// Renderer with the mutation, if there is one, in all its kernels.
pub fn renderer(
    context: &Arc<Context>,
    scene: &Scene,
    bvh: &Bvh,
    settings: &Settings,
    mutation: Option<&str>,
) -> Renderer {
    let mut settings = settings.clone();
    settings.storage_reads |= mutation.is_some();
    let (surfaces, registry) = (Surfaces::new(scene), registry(mutation));
    Renderer::with_surfaces(context, scene, surfaces, bvh, &settings, &registry).expect("a renderer")
}
