// Numbers of the four descriptor sets. Vulkan guarantees only four.
#ifndef SETS_GLSL
#define SETS_GLSL

// Number of a descriptor set.
const uint FRAME_SET = 0u;
const uint BVH_SET = 1u;
const uint RADIANCE_GRID_SET = 2u;
const uint NORMALIZATION_GRID_SET = 3u;

#endif
