// Smooth metal.
#ifndef BSDF_CONDUCTOR_GLSL
#define BSDF_CONDUCTOR_GLSL
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"

BsdfSample sample_bsdf_conductor(Bsdf b, vec3 wo, vec3 u) {
    vec3 weight = b.color0 * fresnel_conductor(wo.z, b.color1, b.color2);
    return BsdfSample(vec3(-wo.xy, wo.z), wo.z > 0.0 ? LOBE_DELTA : LOBE_NONE, weight, 1.0);
}

float pdf_bsdf_conductor(Bsdf b, vec3 wo, vec3 wi) {
    return 0.0;
}

vec3 eval_bsdf_conductor(Bsdf b, vec3 wo, vec3 wi) {
    return vec3(0.0);
}

#endif
