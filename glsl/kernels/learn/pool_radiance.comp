// Computes what a parent cell has learned: for each bin, the mean over its up to eight children. One workgroup handles
// one parent. A child is weighted by its certainty, not by its number of targets, because targets concentrate where the
// camera looks.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/grid/cells.glsl"
#include "guide/grid/radiance_grid.glsl"
#include "records/update_push.glsl"

layout(push_constant, scalar) uniform Push { UpdatePush push; };

LearnedRadiance pooled_radiance(uint parent, uint bin) {
    float sum = 0.0;
    float sum_of_shares = 0.0;
    float weight = 0.0;
    uint end = first_child(parent + 1u);
    for (uint cell = first_child(parent); cell < end; ++cell) {
        LearnedRadiance learned = learned_radiance(radiance_index(cell, bin));
        float share = learned.weight / (learned.weight + FALLBACK);
        sum += share * learned.mean;
        sum_of_shares += share;
        weight += learned.weight;
    }
    return LearnedRadiance(sum_of_shares > 0.0 ? sum / sum_of_shares : 0.0, weight);
}

void main() {
    uint parent = push.first_cell + gl_WorkGroupID.x;
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        store_learned_radiance(radiance_index(parent, bin), pooled_radiance(parent, bin));
    }
}
