// Updates, at the end of a step, the light selection that cells have learned (light_selection.glsl). One workgroup handles one cell.
// It moves the mean of every group of lights towards the mean of the step's evidence, and computes the cell's group tree anew.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/grid/lane_sum.glsl"
#include "light/light_learning.glsl"
#include "records/update_push.glsl"

layout(push_constant, scalar) uniform Push { UpdatePush push; };

// Connections that a group's power counts for as prior evidence.
const float POWER_EVIDENCE = 8.0;
// Shares of the draws that are made in proportion to power, and evenly among all groups that have power, whatever the cell has
// learned. They bound the weight of light that the cell does not know yet.
const float POWER_SHARE = 0.0625;
const float EVEN_SHARE = 0.0625;

shared float weights[256];

LearnedRadiance learn(uint cell, uint group) {
    LearnedRadiance before = learned_radiance(learned_light(cell, group));
    float sum, count;
    take_targets(light_sum(cell, group), scene().target_limit, sum, count);
    return updated_mean(before, push.ends_step != 0u ? DECAY : 1.0, sum, count);
}

// Weights of a node's sixteen parts. The first node of a tree of two levels has the sums of the nodes below it.
mat4 node_weights(uint node) {
    mat4 result = mat4(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    for (uint part = 0u; part < 16u; ++part) {
        float weight = 0.0;
        if (!has_two_light_levels()) weight = weights[part];
        else if (node > 0u) weight = weights[16u * (node - 1u) + part];
        else for (uint i = 0u; i < 16u; ++i) weight += weights[16u * part + i];
        result[part / 4u][part % 4u] = weight;
    }
    return result;
}

void main() {
    uint cell = push.first_cell + gl_WorkGroupID.x;
    float found = 0.0;
    float expected = 0.0;
    float used = 0.0;
    for (uint group = gl_LocalInvocationIndex; group < LIGHT_GROUPS; group += WORKGROUP_SIZE) {
        LearnedRadiance learned = learn(cell, group);
        store_learned_radiance(learned_light(cell, group), learned);
        found += learned.weight * learned.mean;
        expected += learned.weight * power_of_group(group);
        used += power_of_group(group) > 0.0 ? 1.0 : 0.0;
    }
    found = sum_of_lanes(found, LIGHT_GROUPS);
    expected = sum_of_lanes(expected, LIGHT_GROUPS);
    used = sum_of_lanes(used, LIGHT_GROUPS);
    float scale = expected > 0.0 ? found / expected : 0.0;
    float estimates = 0.0;
    for (uint group = gl_LocalInvocationIndex; group < LIGHT_GROUPS; group += WORKGROUP_SIZE) {
        LearnedRadiance learned = learned_radiance(learned_light(cell, group));
        float prior = POWER_EVIDENCE * scale * power_of_group(group);
        float estimate = (learned.weight * learned.mean + prior) / (learned.weight + POWER_EVIDENCE);
        weights[group] = estimate;
        estimates += estimate;
    }
    estimates = sum_of_lanes(estimates, LIGHT_GROUPS);
    float factor = estimates > 0.0 ? (1.0 - POWER_SHARE - EVEN_SHARE) / estimates : 0.0;
    for (uint group = gl_LocalInvocationIndex; group < LIGHT_GROUPS; group += WORKGROUP_SIZE) {
        float even = power_of_group(group) > 0.0 ? EVEN_SHARE / used : 0.0;
        weights[group] = factor * weights[group] + POWER_SHARE * power_of_group(group) + even;
    }
    barrier();
    for (uint node = gl_LocalInvocationIndex; node < group_nodes_per_cell(); node += WORKGROUP_SIZE) {
        store_radiance_node(group_node(cell, node), pack_weights_8(node_weights(node)));
    }
}
