// Thin dielectric sheet. Transmitted light goes straight on.
#ifndef BSDF_THIN_DIELECTRIC_GLSL
#define BSDF_THIN_DIELECTRIC_GLSL
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"

// Samples reflection or transmission. The reflectance of both surfaces, with all reflections between them, is r + (1 -
// r)^2 r (1 + r^2 + r^4 + ...) = 2 r / (1 + r).
BsdfSample sample_bsdf_thin_dielectric(Bsdf b, vec3 wo, vec3 u) {
    float r = fresnel_dielectric(abs(wo.z), b.scalars0.z).reflectance;
    uint lobe = wo.z != 0.0 ? LOBE_DELTA : LOBE_NONE;
    if (u.z < 2.0 * r / (1.0 + r)) return BsdfSample(vec3(-wo.xy, wo.z), lobe, b.color0, 1.0);
    return BsdfSample(-wo, lobe, b.color1, 1.0);
}

// Share of the light that goes straight on through the sheet.
vec3 straight_thin_dielectric(Bsdf b, vec3 wo) {
    float r = fresnel_dielectric(abs(wo.z), b.scalars0.z).reflectance;
    return wo.z != 0.0 ? b.color1 * ((1.0 - r) / (1.0 + r)) : vec3(0.0);
}

float pdf_bsdf_thin_dielectric(Bsdf b, vec3 wo, vec3 wi) {
    return 0.0;
}

vec3 eval_bsdf_thin_dielectric(Bsdf b, vec3 wo, vec3 wi) {
    return vec3(0.0);
}

#endif
