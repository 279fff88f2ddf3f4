// Rough metal with microfacets.
#ifndef BSDF_ROUGH_CONDUCTOR_GLSL
#define BSDF_ROUGH_CONDUCTOR_GLSL
#include "bsdf/conductor.glsl"
#include "math/microfacet.glsl"

// Number of the kind.
const uint BSDF_ROUGH_CONDUCTOR = 6u;

// Samples a reflection. `m` is a visible normal.
BsdfSample sample_bsdf_rough_conductor(Conductor b, vec3 wo, vec3 m) {
    vec3 wi = reflect(-wo, m);
    return BsdfSample(wi, wo.z > 0.0 && wi.z > 0.0 ? LOBE_GLOSSY : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_rough_conductor(Conductor b, vec3 wo, vec3 wi, Facet f) {
    return min(wo.z, wi.z) > 0.0 ? reflected_density(f) : 0.0;
}

vec3 eval_bsdf_rough_conductor(Conductor b, vec3 wo, vec3 wi, Facet f, Film film, Filmed filmed) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    return b.specular_reflectance * conductor_reflectance(b, dot(wo, f.m), film, filmed) * reflected_light(f);
}

float guided_part_bsdf_rough_conductor(Facets b) {
    return guided_roughness(b);
}

#endif
