// Every specialization constant, with its default. Rust sees them as the fields of `kernels::Variant`, in lower case.
#ifndef VARIANT_GLSL
#define VARIANT_GLSL
#include "enums.glsl"

layout(local_size_x_id = 0) in;
// Invocations per workgroup; the same number as local_size_x.
layout(constant_id = 0) const uint WORKGROUP_SIZE = 64u;

layout(constant_id = 1) const uint SAMPLER = SAMPLER_BSDF;
layout(constant_id = 2) const uint LEARNER = LEARNER_SARSA;
// Longest path in edges; 1 is emission seen directly.
layout(constant_id = 3) const uint MAX_DEPTH = 16u;
// Number of edges from which Russian roulette is played.
layout(constant_id = 4) const uint RR_DEPTH = 8u;
layout(constant_id = 5) const bool HIDE_EMITTERS = false;

// Cells along each axis of the grids.
layout(constant_id = 6) const uint GRID_RESOLUTION = 8u;
// Direction bins along each side of the equal-area square.
layout(constant_id = 7) const uint DIRECTION_RESOLUTION = 16u;
// Normal bins along each side of the equal-area square.
layout(constant_id = 8) const uint NORMAL_RESOLUTION = 16u;
// Proposals before a guided sample falls back on the uniform share.
layout(constant_id = 9) const uint MAX_TRIES = 15u;
// Least share of uniformly drawn directions.
layout(constant_id = 10) const float MIN_UNIFORM_SHARE = 0.0625;
// What one step leaves of a bin's earlier count; 1 is the paper's running mean.
layout(constant_id = 11) const float DECAY = 1.0;

layout(constant_id = 12) const uint FILTER = FILTER_BOX;
// Radius of the tent, or standard deviation of the Gaussian, in pixels.
layout(constant_id = 13) const float FILTER_WIDTH = 1.0;

// Entries of the traversal stack: the depth of the BVH.
layout(constant_id = 14) const uint STACK_SIZE = 16u;
layout(constant_id = 15) const bool HAS_SPHERES = false;
layout(constant_id = 16) const bool HAS_VERTEX_NORMALS = true;

layout(constant_id = 24) const uint CAMERA = CAMERA_PERSPECTIVE;

// Multiplies the density that samples are divided by. Not 1 only in tests, which must notice.
layout(constant_id = 17) const float PDF_TAMPER = 1.0;

#endif
