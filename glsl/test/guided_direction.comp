// Draws from sample_guide, or sample_descent, in cell 0 and evaluates pdf_guide, one sample per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/samplers/guided_direction.glsl"

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

// Direction with density cos / pi about n: the normalized sum of n and a uniform point of the unit sphere.
vec3 cosine_about(vec3 n, vec2 u) {
    vec3 w = n + square_to_sphere(2.0 * u - 1.0);
    float length2 = dot(w, w);
    return length2 > 1.0e-8 ? w * inversesqrt(length2) : n;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    Guide guide = guide_of(0u, push.normal, SHARE_OF_LOBES);
    RandomKey key = random_key(uvec2(index, 0u), 0u, 0u, 0u, push.seed);
    float choice = unit_floats(random_bits(key, 1u, RANDOM_SCATTER)).z;
    GuidedSample s;
    if (descends()) {
        vec3 own = cosine_about(guide.n, unit_floats(random_bits(key, 1u, RANDOM_SCATTER)).xy);
        s = sample_descent(unit_floats(random_bits(key, 1u, RANDOM_TRIES)), guide, true, guide.bsdf_share, own);
        s.pdf = product_density(guide, s.wi, s.pdf);
    } else {
        s = sample_guide(key, 1u, choice, guide);
    }
    drawn_samples[index] = Drawn(s.wi, s.pdf, pdf_guide(guide, s.wi), s.tries, s.bin, s.overrun ? 1u : 0u);
}
