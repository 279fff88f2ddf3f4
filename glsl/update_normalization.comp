// Fills the marked entries of the normalization grid from the radiance table: a row of workgroups per cell, an invocation per
// normal bin. The sampler that has no use for normals has one bin of them, and gets the distribution that it inverts.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bin_distribution.glsl"
#include "normalization_entry.glsl"

struct UpdatePush {
    uint first_cell;
};
layout(push_constant, scalar) uniform Push { UpdatePush push; };

void main() {
    uint cell = push.first_cell + gl_WorkGroupID.x;
    uint normal_bin = gl_WorkGroupID.y * WORKGROUP_SIZE + gl_LocalInvocationIndex;
    uint index = normalization_index(cell, normal_bin);
    float total = SAMPLER == SAMPLER_SPHERE_INVERSION ? store_bin_ends(cell) : 0.0;
    if (normal_bin < normal_bin_count() && is_marked(index)) {
        bool is_sphere = SAMPLER == SAMPLER_SPHERE_INVERSION;
        store_normalization_entry(index, is_sphere ? sphere_inversion_factors(total) : normalize_cell(cell, normal_bin));
    }
}
