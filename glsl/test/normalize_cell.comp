// Fills all entries of cell 0 of the normalization grid.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bin_distribution.glsl"
#include "normalization_entry.glsl"

void main() {
    if (SAMPLER == SAMPLER_SPHERE_INVERSION) {
        float total = store_bin_ends(0u);
        if (gl_GlobalInvocationID.x == 0u) store_normalization_entry(0u, sphere_inversion_factors(total));
        return;
    }
    for (uint bin = gl_GlobalInvocationID.x; bin < normal_bin_count(); bin += WORKGROUP_SIZE * gl_NumWorkGroups.x) {
        store_normalization_entry(normalization_index(0u, bin), normalize_cell(0u, bin));
    }
}
