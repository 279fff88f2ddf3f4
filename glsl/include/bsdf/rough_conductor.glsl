// Rough metal with microfacets.
#ifndef BSDF_ROUGH_CONDUCTOR_GLSL
#define BSDF_ROUGH_CONDUCTOR_GLSL
#include "bsdf/parameters.glsl"
#include "math/fresnel.glsl"
#include "math/microfacet.glsl"

// Samples a reflection. `m` is a visible normal.
BsdfSample sample_bsdf_rough_conductor(Bsdf b, vec3 wo, vec3 m) {
    vec3 wi = reflect(-wo, m);
    return BsdfSample(wi, wo.z > 0.0 && wi.z > 0.0 ? LOBE_GLOSSY : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_rough_conductor(Bsdf b, vec3 wo, vec3 wi, Facet f) {
    return min(wo.z, wi.z) > 0.0 ? reflected_density(f) : 0.0;
}

vec3 eval_bsdf_rough_conductor(Bsdf b, vec3 wo, vec3 wi, Facet f) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    return b.color0 * fresnel_conductor(dot(wo, f.m), b.color1, b.color2) * reflected_light(f);
}

#endif
