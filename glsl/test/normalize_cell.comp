// Fills all entries of cell 0 of the normalization grid, and the sampler's own distributions if it has any.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/samplers/bin_distribution.glsl"
#include "guide/normalization/normalization_entry.glsl"
#include "guide/grid/radiance_tree.glsl"
#include "guide/samplers/sampler.glsl"

void main() {
    if (is_sphere_inversion()) {
        float total = store_bin_ends(0u);
        if (gl_GlobalInvocationID.x == 0u) store_normalization_record(0u, texel_of(sphere_inversion_factors(total)));
        return;
    }
    if (is_product()) {
        uint lanes = WORKGROUP_SIZE * gl_NumWorkGroups.x;
        for (uint node = gl_GlobalInvocationID.x; node < nodes_per_tree(); node += lanes) store_tree_node(0u, node);
    }
    for (uint bin = gl_GlobalInvocationID.x; bin < normal_bin_count(); bin += WORKGROUP_SIZE * gl_NumWorkGroups.x) {
        uvec4 record = is_product() ? product_record(0u, bin) : texel_of(normalize_cell(0u, bin));
        store_normalization_record(normalization_index(0u, bin), record);
    }
}
