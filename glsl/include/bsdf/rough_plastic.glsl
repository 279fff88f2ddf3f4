// Rough dielectric layer with microfacets over a diffuse base.
#ifndef BSDF_ROUGH_PLASTIC_GLSL
#define BSDF_ROUGH_PLASTIC_GLSL
#include "bsdf/plastic.glsl"
#include "film/frame.glsl"
#include "math/microfacet.glsl"
#include "shared/records.glsl"

// Number of the kind.
const uint BSDF_ROUGH_PLASTIC = 8u;

struct RoughPlastic {
    Plastic plastic;
    SCALAR(6) float table;                        // address of the words of the layer's transmittances, a whole number; no weighted base has it
    FLAG(MATERIAL_SMOOTH_BASE) bool smooth_base;  // light passes the layer as if it was smooth
};

// Share of the light from above that the layer transmits to the base, interpolated in a table over the cosine. A word
// of the table holds an entry and the next one.
float rough_plastic_transmittance(uint address, float cos_theta) {
    float position = clamp(cos_theta, 0.0, 1.0) * float(TRANSMITTANCE_ENTRIES - 1u);
    uint entry = min(uint(position), TRANSMITTANCE_ENTRIES - 2u);
    vec2 values = unpackUnorm2x16(table_word(address + entry));
    return mix(values.x, values.y, position - float(entry));
}

// Share of the light that the layer transmits. With a smooth base, light passes it as if it was smooth.
float layer_transmittance(RoughPlastic b, float cos_theta, Film film) {
    if (has_feature(FEATURE_SMOOTH_BASE) && b.smooth_base) {
        return 1.0 - filmed_interface(cos_theta, b.plastic.eta, film).reflectance;
    }
    return rough_plastic_transmittance(uint(b.table), cos_theta);
}

// Samples the specular or the diffuse lobe. `m` is a visible normal.
BsdfSample sample_bsdf_rough_plastic(RoughPlastic b, vec3 wo, vec3 m, vec3 u, Film film) {
    bool is_specular = u.z < plastic_specular_probability(b.plastic, 1.0 - layer_transmittance(b, wo.z, film));
    vec3 wi = is_specular ? reflect(-wo, m) : sample_cosine_hemisphere(u.xy);
    uint lobe = is_specular ? LOBE_GLOSSY : LOBE_DIFFUSE;
    return BsdfSample(wi, min(wo.z, wi.z) > 0.0 ? lobe : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_rough_plastic(RoughPlastic b, vec3 wo, vec3 wi, float diffuse_density, Facet f, Film film) {
    if (min(wo.z, wi.z) <= 0.0) return 0.0;
    float specular = plastic_specular_probability(b.plastic, 1.0 - layer_transmittance(b, wo.z, film));
    return density_of_choice(diffuse_density, reflected_density(f), specular);
}

vec3 eval_bsdf_rough_plastic(RoughPlastic b, vec3 wo, vec3 wi, Facet f, Film film, Filmed filmed) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    vec3 reflectance = filmed_reflectance(fresnel_dielectric(dot(wo, f.m), b.plastic.eta), film, filmed);
    vec3 specular = b.plastic.specular_reflectance * (reflectance * reflected_light(f));
    if (has_weighted_base(b.plastic)) return specular + weighted_base_reflection(b.plastic, wo, wi, film, filmed);
    float transmitted = layer_transmittance(b, wo.z, film) * layer_transmittance(b, wi.z, film);
    return specular + plastic_base(b.plastic) * (INV_PI * wi.z * transmitted);
}

#endif
