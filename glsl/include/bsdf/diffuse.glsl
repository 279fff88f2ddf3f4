// Ideal diffuse reflection.
#ifndef BSDF_DIFFUSE_GLSL
#define BSDF_DIFFUSE_GLSL
#include "bsdf/parameters.glsl"
#include "math/direction.glsl"

// Number of the kind.
const uint BSDF_DIFFUSE = 0u;

struct Diffuse {
    COLOR(0) vec3 reflectance;  // albedo, each channel in [0, 1]
};

BsdfSample sample_bsdf_diffuse(Diffuse b, vec3 wo, vec3 u) {
    return BsdfSample(sample_cosine_hemisphere(u.xy), wo.z > 0.0 ? LOBE_DIFFUSE : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_diffuse(Diffuse b, vec3 wo, vec3 wi, float diffuse_density) {
    return wo.z > 0.0 ? diffuse_density : 0.0;
}

vec3 eval_bsdf_diffuse(Diffuse b, vec3 wo, vec3 wi) {
    return wo.z > 0.0 ? b.reflectance * (INV_PI * max(wi.z, 0.0)) : vec3(0.0);
}

#endif
