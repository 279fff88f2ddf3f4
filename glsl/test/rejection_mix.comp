// Draws from sample_rejection_mix in cell 0 and evaluates pdf_rejection_mix, one sample per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "normalization_entry.glsl"
#include "rejection_mix.glsl"

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
    uint normal_bin;
    uint seed;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 0, binding = 0) writeonly buffer DrawnSamples { Drawn drawn_samples[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    vec3 nb = bin_center(push.normal_bin, NORMAL_RESOLUTION);
    NormalizationEntry entry = normalization_entry(normalization_index(0u, push.normal_bin));
    RandomKey key = RandomKey(index, 0u, push.seed);
    float choice = unit_floats(random_bits(key, 1u, RANDOM_SCATTER)).z;
    GuidedSample s = sample_rejection_mix(key, 1u, choice, 0u, nb, push.normal, entry);
    float pdf = pdf_rejection_mix(0u, nb, push.normal, s.wi, entry);
    drawn_samples[index] = Drawn(s.wi, s.pdf, pdf, s.tries, s.bin, s.overrun ? 1u : 0u);
}
