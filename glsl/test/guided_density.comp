// Evaluates pdf_guide in cell 0 somewhere in each bin of a fine map, one bin per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/samplers/guided_direction.glsl"

struct Density {
    vec3 wi;
    float pdf;
};

struct TestPush {
    vec3 normal;
    uint resolution;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) writeonly buffer Densities { Density densities[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    // The point is not the center of the bin: rows of centers would lie along the horizon of some normals.
    vec2 within = unit_floats(random_bits(random_key(uvec2(index, 0u), 0u, 0u, 0u, 0u), 0u, RANDOM_SCATTER)).xy;
    vec3 wi = map_to_sphere(bin_point(index, push.resolution, within));
    densities[index] = Density(wi, pdf_guide(guide_of(0u, push.normal, SHARE_OF_LOBES), wi));
}
