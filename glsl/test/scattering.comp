// Draws one BSDF sample and evaluates the BSDF in one given direction per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bsdf/bsdf.glsl"

struct ScatteringInput {
    Bsdf bsdf;
    vec3 wo;
    vec3 wi;
    vec3 u;
};

struct ScatteringOutput {
    vec3 wi;
    uint lobe;
    vec3 weight;   // f cos / pdf of the sample
    float eta;
    float pdf;     // in the given direction
    vec3 value;
};

layout(scalar, set = 1, binding = 0) readonly buffer ScatteringInputs { ScatteringInput scattering_inputs[]; };
layout(scalar, set = 1, binding = 1) writeonly buffer ScatteringOutputs { ScatteringOutput scattering_outputs[]; };

float density(Bsdf b, vec3 wo, vec3 wi) {
    return pdf_bsdf(b, wo, wi, pdf_cosine_hemisphere(wi.z));
}

void main() {
    ScatteringInput i = scattering_inputs[gl_GlobalInvocationID.x];
    i.bsdf.sheen_lobe = NO_SHEEN_LOBE;
    cover_by_sheen(i.bsdf, i.wo);
    BsdfSample s = sample_bsdf(i.bsdf, i.wo, i.u);
    ScatteringOutput o = ScatteringOutput(s.wi, s.lobe, s.weight, s.eta, density(i.bsdf, i.wo, i.wi), vec3(0.0));
    o.value = eval_bsdf(i.bsdf, i.wo, i.wi);
    if (s.lobe == LOBE_DIFFUSE || s.lobe == LOBE_GLOSSY) {
        o.weight = eval_bsdf(i.bsdf, i.wo, s.wi) / max(density(i.bsdf, i.wo, s.wi), 1.0e-30);
    }
    scattering_outputs[gl_GlobalInvocationID.x] = o;
}
