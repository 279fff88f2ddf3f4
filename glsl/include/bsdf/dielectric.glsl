// Smooth surface between two dielectrics.
#ifndef BSDF_DIELECTRIC_GLSL
#define BSDF_DIELECTRIC_GLSL
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"

// Samples reflection or refraction. Radiance that enters a denser medium is concentrated in a smaller solid angle; the
// weight therefore contains the square of eta.
BsdfSample sample_bsdf_dielectric(Bsdf b, vec3 wo, vec3 u) {
    DielectricInterface i = fresnel_dielectric(wo.z, b.scalars0.z);
    uint lobe = wo.z != 0.0 ? LOBE_DELTA : LOBE_NONE;
    if (u.z < i.reflectance) return BsdfSample(vec3(-wo.xy, wo.z), lobe, b.color0, 1.0);
    vec3 wi = vec3(-wo.xy / i.eta, wo.z > 0.0 ? -i.cos_t : i.cos_t);
    return BsdfSample(wi, lobe, b.color1 / (i.eta * i.eta), i.eta);
}

float pdf_bsdf_dielectric(Bsdf b, vec3 wo, vec3 wi) {
    return 0.0;
}

vec3 eval_bsdf_dielectric(Bsdf b, vec3 wo, vec3 wi) {
    return vec3(0.0);
}

#endif
