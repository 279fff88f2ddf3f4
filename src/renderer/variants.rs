//! The specialization constants of a render, from its settings and its scene.

use crate::encode::bvh::Bvh;
use crate::encode::lights::Lights;
use crate::encode::materials;
use crate::encode::surfaces::{Shading, Surfaces};
use crate::generated::constants;
use crate::generated::kernels::{self, Variant};
use crate::renderer::learn::quadtrees;
use crate::scene::{Projection, ReconstructionFilter, Scene};
use crate::settings::Settings;

/// A traversal's stack has a multiple of so many entries, so that hierarchies of several depths share kernels.
const STACK_STEP: u32 = 8;

/// The specialization constants of a render.
pub fn variant_for(settings: &Settings, scene: &Scene, bvh: &Bvh) -> Variant {
    let shading = Shading { surfaces: Surfaces::new(scene), lights: Lights::new(scene, bvh, settings.learns_lights()) };
    variant(settings, scene, &shading, bvh)
}

/// The specialization constants of a render whose shading is known.
pub(super) fn variant(settings: &Settings, scene: &Scene, shading: &Shading, bvh: &Bvh) -> Variant {
    let lights = &shading.lights;
    let (textured_parameters, max_texture_links) = materials::textured_parameters(scene);
    Variant {
        stack_size: bvh.depth.next_multiple_of(STACK_STEP),
        has_spheres: bvh.has_spheres(),
        has_vertex_normals: bvh.has_vertex_normals(),
        has_front_only: bvh.has_front_only(),
        has_unseen: bvh.has_unseen(),
        has_instances: bvh.has_instances(),
        has_placed_spheres: bvh.has_placed_spheres(),
        has_facing_disks: bvh.has_facing_disks(),
        has_deforming: bvh.deforms(),
        motion_segments: bvh.motions.most_segments(),
        camera_segments: scene.camera_motion.as_ref().map_or(0, |motion| motion.segments().len() as u32),
        camera: camera_kind(scene.camera.projection),
        material_kinds: materials::kinds(scene),
        surface_features: materials::features(scene) | feature_of_connections(shading, bvh),
        texture_kinds: shading.surfaces.textures.kinds,
        program_operations: shading.surfaces.textures.operations as u32,
        program_later_operations: (shading.surfaces.textures.operations >> 32) as u32,
        textured_parameters,
        max_texture_links,
        texel_pages: shading.surfaces.textures.words.pages().len() as u32,
        nee: settings.nee && !lights.is_empty(),
        light_kinds: lights.kinds(),
        light_groups: lights.group_count(),
        light_patches: lights.patches_per_side(),
        environment: lights.environment_kind(),
        ..variant_of_settings(settings)
    }
}

/// The feature that connections to lights go on through materials that refract, where the scene has such materials and lights that a ray
/// can meet.
fn feature_of_connections(shading: &Shading, bvh: &Bvh) -> u32 {
    let mut materials = shading.surfaces.materials.iter();
    let refracts = materials.any(|record| record.kind_and_flags & constants::MATERIAL_REFRACTS != 0);
    let has_environment = shading.lights.environment_kind() != constants::ENVIRONMENT_NONE;
    let meets = || has_environment || bvh.surfaces().any(|(_, _, attributes)| attributes.emitter != constants::NONE);
    if refracts && meets() { constants::FEATURE_REFRACTED_CONNECTIONS } else { 0 }
}

/// The specialization constants that settings alone decide; what a scene decides is left at its default.
pub fn variant_of_settings(settings: &Settings) -> Variant {
    let (filter, filter_width) = match settings.filter {
        ReconstructionFilter::Box => (kernels::FILTER_BOX, 1.0),
        ReconstructionFilter::Tent { radius } => (kernels::FILTER_TENT, radius),
        ReconstructionFilter::Gaussian { stddev } => (kernels::FILTER_GAUSSIAN, stddev),
    };
    Variant {
        sampler: settings.sampler as u32,
        learner: settings.learner as u32,
        guide_set: settings.guide_set as u32,
        pattern: settings.pattern as u32,
        adaptive: settings.noise.is_some(),
        max_depth: settings.depth_bound(),
        sure_roulette_depth: settings.sure_roulette_depth(),
        rr_depth: settings.rr_depth,
        hide_emitters: settings.hide_emitters,
        fallback: settings.fallback(),
        quadtree_nodes: quadtrees::node_limit(settings) as u32,
        direction_resolution: settings.directions,
        normal_resolution: settings.normal_resolution(),
        max_tries: settings.max_tries,
        min_uniform_share: settings.min_uniform,
        decay: settings.decay,
        map: settings.map as u32,
        mix: settings.mix as u32,
        epsilon: settings.epsilon.unwrap_or(0.0),
        learns_share: settings.learns_share(),
        roulette: settings.roulette() as u32,
        expected_directions: settings.expected_directions,
        kept_vertices: settings.kept_vertices(),
        filter,
        filter_width,
        nee: settings.nee,
        ..Variant::default()
    }
}

/// Kind of camera that kernels know for a projection.
pub(super) fn camera_kind(projection: Projection) -> u32 {
    match projection {
        Projection::Perspective => kernels::CAMERA_PERSPECTIVE,
        Projection::ThinLens { .. } => kernels::CAMERA_THINLENS,
        Projection::Orthographic => kernels::CAMERA_ORTHOGRAPHIC,
        Projection::Equirectangular { .. } => kernels::CAMERA_EQUIRECTANGULAR,
        Projection::EqualArea => kernels::CAMERA_EQUAL_AREA,
    }
}
