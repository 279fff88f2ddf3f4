// Blends what each cell has learned with the estimate of its parent cell, and writes the radiance table that the next
// step samples. One workgroup handles one cell. Larger cells come first.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/grid/block_scales.glsl"
#include "guide/grid/cells.glsl"
#include "guide/grid/floor.glsl"
#include "guide/grid/radiance_grid.glsl"

struct UpdatePush {
    uint first_cell;
};
layout(push_constant, scalar) uniform Push { UpdatePush push; };

// Estimate of a bin: (weight mean + FALLBACK S estimate(parent)) / (weight + FALLBACK), with the scale S of the bin's block. The
// largest cell has only its own mean.
float blended_radiance(uint cell, uint bin) {
    LearnedRadiance learned = learned_radiance(radiance_index(cell, bin));
    uint parent = parent_cell(cell);
    if (parent == NONE) return learned.mean;
    float estimate = bin_scale(bin) * learned_radiance(radiance_index(parent, bin)).mean;
    return mix(estimate, learned.mean, learned.weight / (learned.weight + FALLBACK));
}

void blend_parent(uint cell) {
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        uint index = radiance_index(cell, bin);
        store_learned_radiance(index, LearnedRadiance(blended_radiance(cell, bin), learned_radiance(index).weight));
    }
}

void blend_cell(uint cell) {
    float sum = 0.0;
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        float estimate = blended_radiance(cell, bin);
        store_radiance(radiance_index(cell, bin), estimate);
        sum += estimate;
    }
    float least = least_radiance(sum);
    for (uint bin = gl_LocalInvocationIndex; bin < direction_bin_count(); bin += WORKGROUP_SIZE) {
        uint index = radiance_index(cell, bin);
        store_radiance(index, max(radiance(index), least));
    }
}

void main() {
    uint cell = push.first_cell + gl_WorkGroupID.x;
    uint parent = parent_cell(cell);
    if (parent != NONE) measure_blocks(cell, parent);
    if (is_parent(cell)) {
        blend_parent(cell);
    } else {
        blend_cell(cell);
    }
}
