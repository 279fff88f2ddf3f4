// Ends a step's learning (Eq. 7): one workgroup per cell moves every bin's mean towards what the step recorded, and writes
// the table that the next step samples, lifted off zero so that no direction loses its support.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "frame.glsl"
#include "radiance_grid.glsl"
#include "constants.glsl"

struct UpdatePush {
    uint first_cell;
};
layout(push_constant, scalar) uniform Push { UpdatePush push; };

shared float lane_sums[WORKGROUP_SIZE];

// No bin is sampled as if it held less than this share of its cell's mean.
const float FLOOR_SHARE = 1.0 / 64.0;
// Nor less than this share of the largest target: what a cell of zeros is filled with, uniformly.
const float FLOOR_ABSOLUTE = 1.0e-12;

// Rate alpha = count / (count + decayed count of before); with DECAY = 1, the running mean over all targets.
LearnedRadiance learn(LearnedRadiance before, float sum, float target_count) {
    float weight = before.weight * DECAY + target_count;
    if (target_count == 0.0) return LearnedRadiance(before.mean, weight);
    float alpha = target_count / weight;
    return LearnedRadiance(mix(before.mean, sum / target_count, alpha), weight);
}

// Sum over the workgroup, in the same order every time.
float workgroup_sum(float value) {
    lane_sums[gl_LocalInvocationIndex] = value;
    barrier();
    float sum = 0.0;
    for (uint lane = 0u; lane < WORKGROUP_SIZE; ++lane) sum += lane_sums[lane];
    return sum;
}

void main() {
    uint cell = push.first_cell + gl_WorkGroupID.x;
    float sum_of_means = 0.0;
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        uint index = radiance_index(cell, bin);
        float sum, target_count;
        take_targets(index, scene().target_limit, sum, target_count);
        LearnedRadiance learned = learn(learned_radiance(index), sum, target_count);
        store_learned_radiance(index, learned);
        sum_of_means += learned.mean;
    }
    float cell_mean = workgroup_sum(sum_of_means) / float(direction_bin_count());
    float least = max(cell_mean * FLOOR_SHARE, scene().target_limit * FLOOR_ABSOLUTE);
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        uint index = radiance_index(cell, bin);
        store_radiance(index, max(learned_radiance(index).mean, least));
    }
}
