// Evaluates pdf_rejection_mix in cell 0 somewhere in each bin of a fine map, one bin per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "normalization_entry.glsl"
#include "rejection_mix.glsl"

struct Density {
    vec3 wi;
    float pdf;
};

struct TestPush {
    vec3 normal;
    uint normal_bin;
    uint resolution;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) writeonly buffer Densities { Density densities[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    vec3 nb = bin_center(push.normal_bin, NORMAL_RESOLUTION);
    NormalizationEntry entry = normalization_entry(normalization_index(0u, push.normal_bin));
    // Not the center: rows of those would lie along the horizon of some normals.
    vec2 within = unit_floats(random_bits(RandomKey(index, 0u, 0u), 0u, RANDOM_SCATTER)).xy;
    vec2 corner = vec2(index % push.resolution, index / push.resolution);
    vec3 wi = square_to_sphere(2.0 * (corner + within) / float(push.resolution) - 1.0);
    densities[index] = Density(wi, pdf_rejection_mix(0u, nb, push.normal, wi, entry));
}
