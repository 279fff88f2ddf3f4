// Draws from sample_direction at a surface that uses the guide of cell 0, and evaluates pdf_direction in a given
// direction. Each invocation draws one sample.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "path/guiding.glsl"

struct SurfaceInput {
    Bsdf bsdf;
    vec3 wo;      // local
    vec3 normal;  // world space
};

struct DirectionOutput {
    vec3 wi;      // world space
    float pdf;    // 0 for a single direction
    vec3 weight;
    float pdf_of_wi;
    vec3 given;   // given direction, world space
    float pdf_of_given;
    vec3 value_of_given;  // f cos in the given direction
    float scattered;  // evidence about the BSDF share
    float of_guide;
};

struct TestPush {
    uint seed;
    uint count;
};
layout(push_constant, scalar) uniform Push { TestPush push; };
layout(scalar, set = 1, binding = 0) readonly buffer SurfaceInputs { SurfaceInput surface_inputs[]; };
layout(scalar, set = 1, binding = 1) writeonly buffer DirectionOutputs { DirectionOutput direction_outputs[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.count) return;
    SurfaceInput i = surface_inputs[0];
    i.bsdf.sheen_lobe = NO_SHEEN_LOBE;
    cover_by_sheen(i.bsdf, i.wo);
    Scatterer x = Scatterer(i.bsdf, basis_from_normal(i.normal), i.wo, vec3(0.0, 0.0, 1.0), false, 0u);
    Guide guide = guide_at(x);
    RandomKey key = random_key(uvec2(index, 0u), 0u, 0u, 0u, push.seed);
    DirectionSample s = sample_direction(key, 1u, unit_floats(random_bits(key, 1u, RANDOM_SCATTER)), x, guide);
    DirectionOutput o;
    o.wi = s.wi;
    o.pdf = s.pdf;
    o.weight = s.weight;
    o.pdf_of_wi = pdf_direction(x, guide, s.wi * x.frame);
    o.given = map_to_sphere(2.0 * unit_floats(random_bits(key, 2u, RANDOM_SCATTER)).xy - 1.0);
    o.pdf_of_given = pdf_direction(x, guide, o.given * x.frame);
    o.value_of_given = eval_scatterer(x, o.given * x.frame);
    o.scattered = s.evidence.scattered;
    o.of_guide = s.evidence.of_guide;
    direction_outputs[index] = o;
}
