// Draws from sample_guide in cell 0 and evaluates pdf_guide, one sample per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guided_direction.glsl"

struct Drawn {
    vec3 wi;
    float pdf;
    float pdf_of_wi;
    uint tries;
    uint bin;
    uint overrun;
};

struct TestPush {
    vec3 normal;
    uint seed;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) writeonly buffer DrawnSamples { Drawn drawn_samples[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    Guide guide = guide_of(0u, push.normal);
    RandomKey key = RandomKey(index, 0u, push.seed);
    float choice = unit_floats(random_bits(key, 1u, RANDOM_SCATTER)).z;
    GuidedSample s = sample_guide(key, 1u, choice, guide);
    drawn_samples[index] = Drawn(s.wi, s.pdf, pdf_guide(guide, s.wi), s.tries, s.bin, s.overrun ? 1u : 0u);
}
