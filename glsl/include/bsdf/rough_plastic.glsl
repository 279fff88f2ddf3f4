// Rough dielectric layer with microfacets over a diffuse base.
#ifndef BSDF_ROUGH_PLASTIC_GLSL
#define BSDF_ROUGH_PLASTIC_GLSL
#include "bsdf/plastic.glsl"
#include "film/frame.glsl"
#include "math/microfacet.glsl"
#include "shared/records.glsl"

// Share of the light from above that the layer transmits to the base, interpolated in a table over the cosine. A word
// of the table holds an entry and the next one. The tables lie in the first page.
float rough_plastic_transmittance(uint address, float cos_theta) {
    float position = clamp(cos_theta, 0.0, 1.0) * float(TRANSMITTANCE_ENTRIES - 1u);
    uint entry = min(uint(position), TRANSMITTANCE_ENTRIES - 2u);
    vec2 values = unpackUnorm2x16(paged_texel_word(0u, address + entry));
    return mix(values.x, values.y, position - float(entry));
}

// Share of the light that the layer transmits. With MATERIAL_SMOOTH_BASE, light passes it as if it was smooth.
float layer_transmittance(Bsdf b, float cos_theta) {
    if (has_feature(FEATURE_SMOOTH_BASE) && bsdf_flag(b, MATERIAL_SMOOTH_BASE)) {
        return 1.0 - fresnel_dielectric(cos_theta, b.scalars0.z).reflectance;
    }
    return rough_plastic_transmittance(uint(b.scalars1.z), cos_theta);
}

// Samples the specular or the diffuse lobe. `m` is a visible normal.
BsdfSample sample_bsdf_rough_plastic(Bsdf b, vec3 wo, vec3 m, vec3 u) {
    bool is_specular = u.z < plastic_specular_probability(b, 1.0 - layer_transmittance(b, wo.z));
    vec3 wi = is_specular ? reflect(-wo, m) : sample_cosine_hemisphere(u.xy);
    uint lobe = is_specular ? LOBE_GLOSSY : LOBE_DIFFUSE;
    return BsdfSample(wi, min(wo.z, wi.z) > 0.0 ? lobe : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_rough_plastic(Bsdf b, vec3 wo, vec3 wi, float diffuse_density, Facet f) {
    if (min(wo.z, wi.z) <= 0.0) return 0.0;
    float specular = plastic_specular_probability(b, 1.0 - layer_transmittance(b, wo.z));
    return density_of_choice(diffuse_density, reflected_density(f), specular);
}

vec3 eval_bsdf_rough_plastic(Bsdf b, vec3 wo, vec3 wi, Facet f) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    float reflectance = fresnel_dielectric(dot(wo, f.m), b.scalars0.z).reflectance;
    float transmitted = layer_transmittance(b, wo.z) * layer_transmittance(b, wi.z);
    return b.color1 * (reflectance * reflected_light(f)) + plastic_base(b) * (INV_PI * wi.z * transmitted);
}

#endif
