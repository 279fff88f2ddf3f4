// What a cell is sampled by: its estimate, lifted off zero so that no direction loses its support.
#ifndef FLOOR_GLSL
#define FLOOR_GLSL
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"

shared float lane_sums[WORKGROUP_SIZE];

// No bin is sampled as if it held less than this share of its cell's mean.
const float FLOOR_SHARE = 1.0 / 64.0;
// Nor less than this share of the largest target: what a cell of zeros is filled with, uniformly.
const float FLOOR_ABSOLUTE = 1.0e-12;

// Sum over the workgroup, in the same order every time.
float workgroup_sum(float value) {
    lane_sums[gl_LocalInvocationIndex] = value;
    barrier();
    float sum = 0.0;
    for (uint lane = 0u; lane < WORKGROUP_SIZE; ++lane) sum += lane_sums[lane];
    return sum;
}

// The least that a bin is sampled by, where `sum` is of the estimates of a lane's bins.
float least_radiance(float sum) {
    float cell_mean = workgroup_sum(sum) / float(direction_bin_count());
    return max(cell_mean * FLOOR_SHARE, scene().target_limit * FLOOR_ABSOLUTE);
}

#endif
