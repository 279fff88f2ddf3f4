// Ideal diffuse reflection, in a frame whose z-axis is the normal on the side of `wo`.
#ifndef BSDF_DIFFUSE_GLSL
#define BSDF_DIFFUSE_GLSL
#include "direction.glsl"

vec3 sample_bsdf_diffuse(vec2 u) {
    return sample_cosine_hemisphere(u);
}

float pdf_bsdf_diffuse(vec3 wi) {
    return pdf_cosine_hemisphere(wi.z);
}

// f times the cosine.
vec3 eval_bsdf_diffuse(vec3 reflectance, vec3 wi) {
    return reflectance * pdf_cosine_hemisphere(wi.z);
}

#endif
