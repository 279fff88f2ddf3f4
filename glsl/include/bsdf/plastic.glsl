// Smooth dielectric layer over a diffuse base.
#ifndef BSDF_PLASTIC_GLSL
#define BSDF_PLASTIC_GLSL
#include "bsdf/parameters.glsl"
#include "math/direction.glsl"
#include "math/fresnel.glsl"

// Diffuse reflectance of the base including all reflections between base and layer, without the layer's transmittances.
vec3 plastic_base(Bsdf b) {
    vec3 internal = bsdf_flag(b, MATERIAL_NONLINEAR) ? b.color0 * b.scalars1.x : vec3(b.scalars1.x);
    return b.color0 / (max(1.0 - internal, vec3(1.0e-6)) * (b.scalars0.z * b.scalars0.z));
}

// Probability of the specular lobe, given the layer's reflectance for the light from `wo`.
float plastic_specular_probability(Bsdf b, float reflectance) {
    float specular = reflectance * b.scalars1.y;
    float diffuse = (1.0 - reflectance) * (1.0 - b.scalars1.y);
    // A device may round the quotient above 1.
    return min(specular / max(specular + diffuse, 1.0e-20), 1.0);
}

BsdfSample sample_bsdf_plastic(Bsdf b, vec3 wo, vec3 u) {
    if (wo.z <= 0.0) return NO_BSDF_SAMPLE;
    float reflectance = fresnel_dielectric(wo.z, b.scalars0.z).reflectance;
    float specular = plastic_specular_probability(b, reflectance);
    if (u.z >= specular) return BsdfSample(sample_cosine_hemisphere(u.xy), LOBE_DIFFUSE, vec3(0.0), 1.0);
    return BsdfSample(vec3(-wo.xy, wo.z), LOBE_DELTA, b.color1 * (reflectance / specular), 1.0);
}

float pdf_bsdf_plastic(Bsdf b, vec3 wo, vec3 wi, float diffuse_density) {
    if (min(wo.z, wi.z) <= 0.0) return 0.0;
    float reflectance = fresnel_dielectric(wo.z, b.scalars0.z).reflectance;
    return (1.0 - plastic_specular_probability(b, reflectance)) * diffuse_density;
}

vec3 eval_bsdf_plastic(Bsdf b, vec3 wo, vec3 wi) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    float transmitted_o = 1.0 - fresnel_dielectric(wo.z, b.scalars0.z).reflectance;
    float transmitted_i = 1.0 - fresnel_dielectric(wi.z, b.scalars0.z).reflectance;
    return plastic_base(b) * (INV_PI * wi.z * transmitted_o * transmitted_i);
}

#endif
