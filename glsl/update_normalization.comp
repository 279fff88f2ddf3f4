// Fills the marked entries of the normalization grid from the radiance table: a row of workgroups per cell, an invocation per
// normal bin.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "normalization_entry.glsl"

struct UpdatePush {
    uint first_cell;
};
layout(push_constant, scalar) uniform Push { UpdatePush push; };

void main() {
    uint cell = push.first_cell + gl_WorkGroupID.x;
    uint normal_bin = gl_WorkGroupID.y * WORKGROUP_SIZE + gl_LocalInvocationIndex;
    uint index = normalization_index(cell, normal_bin);
    if (normal_bin < normal_bin_count() && is_marked(index)) {
        store_normalization_entry(index, normalize_cell(cell, normal_bin));
    }
}
