// Every specialization constant, with its default. Rust sees them as the fields of `kernels::Variant`, in lower case.
#ifndef VARIANT_GLSL
#define VARIANT_GLSL
#include "shared/enums.glsl"
#include "shared/records.glsl"

layout(local_size_x_id = 0) in;
// Invocations per workgroup; the same number as local_size_x.
layout(constant_id = 0) const uint WORKGROUP_SIZE = 64u;

layout(constant_id = 1) const uint SAMPLER = SAMPLER_BSDF;
layout(constant_id = 2) const uint LEARNER = LEARNER_SARSA;
layout(constant_id = 54) const uint GUIDE_SET = GUIDE_SET_DIFFUSE;
// Longest path in edges; 1 is emission seen directly.
layout(constant_id = 3) const uint MAX_DEPTH = 16u;
// Number of edges from which Russian roulette by throughput is played.
layout(constant_id = 4) const uint RR_DEPTH = 8u;
layout(constant_id = 5) const bool HIDE_EMITTERS = false;

// Targets that a cell's parents count for in the mean of each of its bins; 0: it stands for itself.
layout(constant_id = 60) const float FALLBACK = 0.0;
// Most nodes of all quadtrees of directions.
layout(constant_id = 6) const uint QUADTREE_NODES = 131072u;
// Direction bins along each side of the map.
layout(constant_id = 7) const uint DIRECTION_RESOLUTION = 16u;
// Normal bins along each side of the equal-area square.
layout(constant_id = 8) const uint NORMAL_RESOLUTION = 16u;
// Proposals before a guided sample falls back on the uniform share.
layout(constant_id = 9) const uint MAX_TRIES = 15u;
// Words of the radiance table before the cells' shares of the scattering function, where a guide descends; 0: fixed shares.
layout(constant_id = 56) const uint SHARES_AT = 0u;
// What Russian roulette goes by.
layout(constant_id = 58) const uint ROULETTE = ROULETTE_THROUGHPUT;
// Least share of uniformly drawn directions.
layout(constant_id = 10) const float MIN_UNIFORM_SHARE = 0.0625;
// What one step leaves of a bin's earlier count; 1 is the paper's running mean.
layout(constant_id = 11) const float DECAY = 1.0;

// How a pixel's samples are distributed.
layout(constant_id = 55) const uint PATTERN = PATTERN_INDEPENDENT;
// Whether tiles of the film are sampled as long as they are noisy.
layout(constant_id = 62) const bool ADAPTIVE = false;

layout(constant_id = 12) const uint FILTER = FILTER_BOX;
// Radius of the tent, or standard deviation of the Gaussian, in pixels.
layout(constant_id = 13) const float FILTER_WIDTH = 1.0;

// Entries of the traversal stack: the depth of the BVH.
layout(constant_id = 14) const uint STACK_SIZE = 16u;
layout(constant_id = 15) const bool HAS_SPHERES = false;
layout(constant_id = 16) const bool HAS_VERTEX_NORMALS = true;

// Bit 1 << kind for every kind of material in the scene.
layout(constant_id = 18) const uint MATERIAL_KINDS = 1u;
// FEATURE_* bits.
layout(constant_id = 19) const uint SURFACE_FEATURES = 0u;

// Between directions and the squares of their bins.
layout(constant_id = 30) const uint MAP = MAP_EQUAL_AREA;
// What rejection-mix mixes with the uniform share; MIX_DENSITY for all others.
layout(constant_id = 31) const uint MIX = MIX_DENSITY;
// The share e of Eq. 8 and 9; 0 takes the optimal one.
layout(constant_id = 32) const float EPSILON = 0.0;

// Directions over which expected-sarsa takes its mean.
layout(constant_id = 33) const uint EXPECTED_DIRECTIONS = 128u;
// Vertices that monte-carlo keeps of a path: all of them, or 1 for the other learners.
layout(constant_id = 34) const uint KEPT_VERTICES = 1u;

// Emitter sampling.
layout(constant_id = 40) const bool NEE = false;
// Bit 1 << kind for every kind of light in the scene.
layout(constant_id = 41) const uint LIGHT_KINDS = 0u;
layout(constant_id = 42) const uint ENVIRONMENT = ENVIRONMENT_NONE;

// TEXTURE_* bits of all textures.
layout(constant_id = 50) const uint TEXTURE_KINDS = 0u;
// Bit 1 << parameter for every parameter that has a texture in some material.
layout(constant_id = 51) const uint TEXTURED_PARAMETERS = 0u;
// The most textures that parameters of one material have.
layout(constant_id = 52) const uint MAX_TEXTURE_LINKS = TEXTURE_LINKS;
// Buffers that texel words are spread over.
layout(constant_id = 53) const uint TEXEL_PAGES = 1u;
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

bool is_textured(uint parameter) {
    return (TEXTURED_PARAMETERS & (1u << parameter)) != 0u;
}

bool has_feature(uint feature) {
    return (SURFACE_FEATURES & feature) != 0u;
}

#endif
