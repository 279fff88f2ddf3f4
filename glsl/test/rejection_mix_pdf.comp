// Evaluates pdf_rejection_mix in cell 0 at the centers of a fine map's bins, one per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "normalization_entry.glsl"
#include "rejection_mix.glsl"

struct TestPush {
    vec3 normal;
    uint normal_bin;
    uint resolution;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) writeonly buffer Densities { float densities[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    vec3 nb = bin_center(push.normal_bin, NORMAL_RESOLUTION);
    NormalizationEntry entry = normalization_entry(normalization_index(0u, push.normal_bin));
    densities[index] = pdf_rejection_mix(0u, nb, push.normal, bin_center(index, push.resolution), entry);
}
