// Fills all entries of cell 0 of the normalization grid.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "normalization_entry.glsl"

void main() {
    for (uint bin = gl_GlobalInvocationID.x; bin < normal_bin_count(); bin += WORKGROUP_SIZE * gl_NumWorkGroups.x) {
        store_normalization_entry(normalization_index(0u, bin), normalize_cell(0u, bin));
    }
}
