// Every specialization constant, with its default. Rust has them as the fields of generated::kernels::Variant.
#ifndef VARIANT_GLSL
#define VARIANT_GLSL
#include "shared/enums.glsl"
#include "shared/records.glsl"

layout(local_size_x_id = 0) in;
// Invocations per workgroup; equal to local_size_x.
layout(constant_id = 0) const uint WORKGROUP_SIZE = 64u;

// Sampler of scattered directions: SAMPLER_*.
layout(constant_id = 1) const uint SAMPLER = SAMPLER_BSDF;
// Learner of the radiance grid: LEARNER_*.
layout(constant_id = 2) const uint LEARNER = LEARNER_SARSA;
// BSDFs on which the guide is used: GUIDE_SET_*.
layout(constant_id = 54) const uint GUIDE_SET = GUIDE_SET_DIFFUSE;
// Maximum path length, in edges; 1 is emission seen directly.
layout(constant_id = 3) const uint MAX_DEPTH = 16u;
// Edge from which no path survives with a probability above MOST_SURVIVAL, whatever roulette compares with. Paths without a
// maximum length end by it, long before MAX_DEPTH.
layout(constant_id = 63) const uint SURE_ROULETTE_DEPTH = NONE;
// Number of edges from which Russian roulette by throughput is played.
layout(constant_id = 4) const uint RR_DEPTH = 8u;
// Whether emitters are invisible to the camera.
layout(constant_id = 5) const bool HIDE_EMITTERS = false;
// Whether some shape is invisible to the camera, other than disks that face what they light.
layout(constant_id = 26) const bool HAS_UNSEEN = false;

// Prior weight of a cell's parent in the mean of each bin, as a number of targets; 0 switches parents off.
layout(constant_id = 60) const float FALLBACK = 0.0;
// Maximum number of nodes of all quadtrees together.
layout(constant_id = 6) const uint QUADTREE_NODES = 131072u;
// Direction bins along each side of the map.
layout(constant_id = 7) const uint DIRECTION_RESOLUTION = 16u;
// Normal bins along each side of the equal-area square.
layout(constant_id = 8) const uint NORMAL_RESOLUTION = 16u;
// Maximum number of proposals of a guided sample; if none is accepted, the uniform share draws the direction.
layout(constant_id = 9) const uint MAX_TRIES = 15u;
// Whether cells learn their BSDF shares, for the samplers that descend. Otherwise the shares are fixed.
layout(constant_id = 56) const bool LEARNS_SHARE = false;
// Quantity that Russian roulette uses: ROULETTE_*.
layout(constant_id = 58) const uint ROULETTE = ROULETTE_THROUGHPUT;
// Minimum share of uniformly drawn directions.
layout(constant_id = 10) const float MIN_UNIFORM_SHARE = 0.0625;
// Factor by which each step multiplies a bin's earlier count; 1 gives the running mean of the paper.
layout(constant_id = 11) const float DECAY = 1.0;

// Pattern in which a pixel's samples are distributed: PATTERN_*.
layout(constant_id = 55) const uint PATTERN = PATTERN_INDEPENDENT;
// Whether adaptive sampling is on: only tiles that are still noisy receive samples.
layout(constant_id = 62) const bool ADAPTIVE = false;

// Reconstruction filter: FILTER_*.
layout(constant_id = 12) const uint FILTER = FILTER_BOX;
// Radius of the tent filter, or standard deviation of the Gaussian filter, in pixels.
layout(constant_id = 13) const float FILTER_WIDTH = 1.0;

// Entries of the traversal stack: at least the depth of the BVH.
layout(constant_id = 14) const uint STACK_SIZE = 16u;
// Whether the scene contains spheres.
layout(constant_id = 15) const bool HAS_SPHERES = false;
// Whether some primitive has vertex normals.
layout(constant_id = 16) const bool HAS_VERTEX_NORMALS = true;
// Whether some primitive is met from the front only.
layout(constant_id = 17) const bool HAS_FRONT_ONLY = false;

// Whether some geometry of the scene is shown by instances.
layout(constant_id = 20) const bool HAS_INSTANCES = false;
// Whether some instance shows a sphere.
layout(constant_id = 21) const bool HAS_PLACED_SPHERES = false;
// Whether some primitive is a disk that faces the point which it lights.
layout(constant_id = 25) const bool HAS_FACING_DISKS = false;
// Maximum number of segments of an instance's motion; 0 where no instance moves.
layout(constant_id = 22) const uint MOTION_SEGMENTS = 0u;
// Number of segments of the camera's motion; 0 where it stands still.
layout(constant_id = 23) const uint CAMERA_SEGMENTS = 0u;
// Whether the vertices of some triangle move while the shutter is open.
layout(constant_id = 27) const bool HAS_DEFORMING = false;

// Kinds of material in the scene: bit 1 << kind for each kind.
layout(constant_id = 18) const uint MATERIAL_KINDS = 1u;
// Features that the scene's materials and emitters use: FEATURE_* bits.
layout(constant_id = 19) const uint SURFACE_FEATURES = 0u;

// Map between directions and the square of bins: MAP_*.
layout(constant_id = 30) const uint MAP = MAP_EQUAL_AREA;
// Quantity that rejection-mix mixes with the uniform share: MIX_*. MIX_DENSITY for all other samplers.
layout(constant_id = 31) const uint MIX = MIX_DENSITY;
// Share e of Eq. 8 and Eq. 9; 0 selects the optimal share.
layout(constant_id = 32) const float EPSILON = 0.0;

// Number of directions over which the learner expected-sarsa takes its mean.
layout(constant_id = 33) const uint EXPECTED_DIRECTIONS = 128u;
// Number of vertices that a path keeps: the whole path for the learner monte-carlo, 1 for the others.
layout(constant_id = 34) const uint KEPT_VERTICES = 1u;

// Whether emitter sampling is on.
layout(constant_id = 40) const bool NEE = false;
// Groups of lights among which cells learn to choose: 16 or 256; 0: lights are drawn in proportion to their power.
layout(constant_id = 64) const uint LIGHT_GROUPS = 0u;
// Patches along each side of an area light. Each patch is a light of its own.
layout(constant_id = 65) const uint LIGHT_PATCHES = 1u;
// Kinds of light in the scene: bit 1 << kind for each kind.
layout(constant_id = 41) const uint LIGHT_KINDS = 0u;
// Kind of environment: ENVIRONMENT_*.
layout(constant_id = 42) const uint ENVIRONMENT = ENVIRONMENT_NONE;

// Union of the TEXTURE_* bits of all textures.
layout(constant_id = 50) const uint TEXTURE_KINDS = 0u;
// Parameters that have a texture in some material: bit 1 << parameter for each.
layout(constant_id = 51) const uint TEXTURED_PARAMETERS = 0u;
// Maximum number of texture links that one material of the scene has.
layout(constant_id = 52) const uint MAX_TEXTURE_LINKS = TEXTURE_LINKS;
// Number of buffers over which the texel words are distributed.
layout(constant_id = 53) const uint TEXEL_PAGES = 1u;
// Operations of programs of textures in the scene: bit 1 << operation for each below 32.
layout(constant_id = 70) const uint PROGRAM_OPERATIONS = 0u;
// The other operations of programs: bit 1 << operation - 32.
layout(constant_id = 71) const uint PROGRAM_LATER_OPERATIONS = 0u;
// Kind of camera: CAMERA_*.
layout(constant_id = 24) const uint CAMERA = CAMERA_PERSPECTIVE;

bool mixes_acceptances() {
    return MIX == MIX_ACCEPTANCE;
}

bool has_kind(uint kind) {
    return (MATERIAL_KINDS & (1u << kind)) != 0u;
}

bool has_light(uint kind) {
    return (LIGHT_KINDS & (1u << kind)) != 0u;
}

bool has_textures(uint kinds) {
    return (TEXTURE_KINDS & kinds) != 0u;
}

bool has_operation(uint operation) {
    return ((operation < 32u ? PROGRAM_OPERATIONS : PROGRAM_LATER_OPERATIONS) & (1u << (operation & 31u))) != 0u;
}

bool is_textured(uint parameter) {
    return (TEXTURED_PARAMETERS & (1u << parameter)) != 0u;
}

bool has_feature(uint feature) {
    return (SURFACE_FEATURES & feature) != 0u;
}

#endif
