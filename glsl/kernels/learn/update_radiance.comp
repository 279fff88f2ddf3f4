// Updates the radiance grid at the end of a step (Eq. 7). One workgroup handles one cell. It moves the mean of every
// bin towards the mean of the step's targets. It also writes the table that the next step samples, unless
// blend_radiance does.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/grid/floor.glsl"
#include "guide/grid/lane_sum.glsl"
#include "film/frame.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "guide/learners/share_learning.glsl"
#include "records/update_push.glsl"

layout(push_constant, scalar) uniform Push { UpdatePush push; };

void main() {
    uint cell = push.first_cell + gl_WorkGroupID.x;
    bool ends_step = push.ends_step != 0u;
    float sum_of_means = 0.0;
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        uint index = radiance_index(cell, bin);
        float sum, target_count;
        take_targets(index, scene().target_limit, sum, target_count);
        LearnedRadiance learned = updated_mean(learned_radiance(index), ends_step ? DECAY : 1.0, sum, target_count);
        store_learned_radiance(index, learned);
        sum_of_means += learned.mean;
    }
    if (learns_share() && gl_LocalInvocationIndex < SHARES_PER_CELL) {
        learn_share(share_index(cell, gl_LocalInvocationIndex), ends_step ? SHARE_DECAY : 1.0);
    }
    if (FALLBACK > 0.0) return;
    float least = least_radiance(sum_of_lanes(sum_of_means, WORKGROUP_SIZE));
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        uint index = radiance_index(cell, bin);
        store_radiance(index, max(learned_radiance(index).mean, least));
    }
}
