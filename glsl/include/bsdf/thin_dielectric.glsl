// Thin dielectric sheet. Transmitted light goes straight on.
#ifndef BSDF_THIN_DIELECTRIC_GLSL
#define BSDF_THIN_DIELECTRIC_GLSL
#include "bsdf/dielectric.glsl"
#include "math/fresnel.glsl"

// Number of the kind.
const uint BSDF_THIN_DIELECTRIC = 3u;

// Samples reflection or transmission. The reflectance of both surfaces, with all reflections between them, is r + (1 -
// r)^2 r (1 + r^2 + r^4 + ...) = 2 r / (1 + r).
BsdfSample sample_bsdf_thin_dielectric(Dielectric b, vec3 wo, vec3 u) {
    float r = fresnel_dielectric(abs(wo.z), b.eta).reflectance;
    uint lobe = wo.z != 0.0 ? LOBE_DELTA : LOBE_NONE;
    if (u.z < 2.0 * r / (1.0 + r)) return BsdfSample(vec3(-wo.xy, wo.z), lobe, b.specular_reflectance, 1.0);
    return BsdfSample(-wo, lobe, b.specular_transmittance, 1.0);
}

// Share of the light that goes straight on through the sheet.
vec3 straight_thin_dielectric(Dielectric b, vec3 wo) {
    float r = fresnel_dielectric(abs(wo.z), b.eta).reflectance;
    return wo.z != 0.0 ? b.specular_transmittance * ((1.0 - r) / (1.0 + r)) : vec3(0.0);
}

#endif
