// Fills the marked entries of the normalization grid from the radiance table. One workgroup handles one cell, and one
// invocation one marked entry; most cells have few. For samplers with a distribution that does not depend on the
// normal, the kernel computes that distribution, too: the prefix sums of sphere-inversion, which has a single normal
// bin, and the cells' trees of the product sampler.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/samplers/bin_distribution.glsl"
#include "guide/normalization/normalization_entry.glsl"
#include "guide/grid/radiance_tree.glsl"
#include "guide/samplers/sampler.glsl"
#include "records/update_push.glsl"

layout(push_constant, scalar) uniform Push { UpdatePush push; };

uvec4 record_for(uint cell, uint normal_bin, float total) {
    if (is_product()) return product_record(cell, normal_bin);
    return texel_of(is_sphere_inversion() ? sphere_inversion_factors(total) : normalize_cell(cell, normal_bin));
}

void main() {
    uint cell = push.first_cell + gl_WorkGroupID.x;
    float total = is_sphere_inversion() ? store_bin_ends(cell) : 0.0;
    if (is_product()) {
        for (uint node = gl_LocalInvocationIndex; node < nodes_per_tree(); node += WORKGROUP_SIZE) store_tree_node(cell, node);
    }
    uint place = gl_LocalInvocationIndex;
    uint normal_bin = marked_normal_bin(cell, place);
    while (normal_bin != NONE) {
        store_normalization_record(normalization_index(cell, normal_bin), record_for(cell, normal_bin, total));
        place += WORKGROUP_SIZE;
        normal_bin = marked_normal_bin(cell, place);
    }
}
