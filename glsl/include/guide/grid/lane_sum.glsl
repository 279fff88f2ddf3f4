// Sums over the lanes of a workgroup.
#ifndef LANE_SUM_GLSL
#define LANE_SUM_GLSL
#include "shared/variant.glsl"

shared float lane_sums[WORKGROUP_SIZE];

// Sum over the first `count` lanes, or over all if they are fewer. The order of the additions is fixed. All lanes call this
// function.
float sum_of_lanes(float value, uint count) {
    barrier();
    lane_sums[gl_LocalInvocationIndex] = value;
    barrier();
    float sum = 0.0;
    for (uint lane = 0u; lane < min(WORKGROUP_SIZE, count); ++lane) sum += lane_sums[lane];
    return sum;
}

#endif
