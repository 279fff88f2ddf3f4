// Smooth dielectric layer over a diffuse base.
#ifndef BSDF_PLASTIC_GLSL
#define BSDF_PLASTIC_GLSL
#include "bsdf/film.glsl"
#include "bsdf/parameters.glsl"
#include "bsdf/rough_diffuse.glsl"
#include "math/direction.glsl"
#include "math/fresnel.glsl"

// Number of the kind.
const uint BSDF_PLASTIC = 7u;

// Parameters of all plastics.
struct Plastic {
    COLOR(0) vec3 diffuse_reflectance;         // albedo of the base
    COLOR(1) vec3 specular_reflectance;        // factor of the light that the layer reflects
    SCALAR(2) float eta;                       // index of refraction, interior over exterior
    SCALAR(4) float internal_reflectance;      // diffuse Fresnel reflectance from inside
    SCALAR(5) float specular_sampling;         // mean albedo of the specular lobe over that of both lobes
    SCALAR(6) float base_roughness;            // of a base that is rough
    SCALAR(7) float base_weight;               // share of the base that is left under what the layer reflects, for a weighted base
    FLAG(MATERIAL_NONLINEAR) bool nonlinear;   // color shifts by internal scattering are kept
    FLAG(MATERIAL_WEIGHTED_BASE) bool weighted_base;
    FLAG(MATERIAL_ENERGY_PRESERVING) bool rough_base;  // a weighted base is rough, by the energy-preserving model
};

// Whether a weight says what the base sheds, so that the layer dims nothing.
bool has_weighted_base(Plastic b) {
    return has_feature(FEATURE_WEIGHTED_BASE) && b.weighted_base;
}

// Albedo of a weighted base.
vec3 weighted_base(Plastic b) {
    return b.base_weight * b.diffuse_reflectance;
}

// What a weighted base reflects: f cos. A film keeps from it what it reflects most, as in Cycles.
vec3 weighted_base_reflection(Plastic b, vec3 wo, vec3 wi, Film film, Filmed filmed) {
    if (is_filmed(film)) b.base_weight *= 1.0 - max_component(filmed.other);
    if (has_feature(FEATURE_ENERGY_PRESERVING) && b.rough_base) {
        return b.base_weight * energy_preserving_reflection(b.diffuse_reflectance, b.base_roughness, wo, wi);
    }
    return weighted_base(b) * (INV_PI * wi.z);
}

// Diffuse reflectance of the base including all reflections between base and layer, without the layer's transmittances.
vec3 plastic_base(Plastic b) {
    vec3 internal = b.nonlinear ? b.diffuse_reflectance * b.internal_reflectance : vec3(b.internal_reflectance);
    return b.diffuse_reflectance / (max(1.0 - internal, vec3(1.0e-6)) * (b.eta * b.eta));
}

// Probability of the specular lobe, given the layer's reflectance for the light from `wo`. With a weighted base, it follows what both
// lobes shed at the point.
float plastic_specular_probability(Plastic b, float reflectance) {
    float specular = reflectance * b.specular_sampling;
    float diffuse = (1.0 - reflectance) * (1.0 - b.specular_sampling);
    if (has_weighted_base(b)) {
        specular = reflectance * max_component(b.specular_reflectance);
        diffuse = max_component(weighted_base(b));
    }
    // A device may round the quotient above 1.
    return min(specular / max(specular + diffuse, 1.0e-20), 1.0);
}

BsdfSample sample_bsdf_plastic(Plastic b, vec3 wo, vec3 u, Film film, Filmed filmed) {
    if (wo.z <= 0.0) return NO_BSDF_SAMPLE;
    DielectricInterface i = filmed_interface(wo.z, b.eta, film);
    float specular = plastic_specular_probability(b, i.reflectance);
    if (u.z >= specular) return BsdfSample(sample_cosine_hemisphere(u.xy), LOBE_DIFFUSE, vec3(0.0), 1.0);
    vec3 weight = b.specular_reflectance * (filmed_reflectance(i, film, filmed) / specular);
    return BsdfSample(vec3(-wo.xy, wo.z), LOBE_DELTA, weight, 1.0);
}

float pdf_bsdf_plastic(Plastic b, vec3 wo, vec3 wi, float diffuse_density, Film film) {
    if (min(wo.z, wi.z) <= 0.0) return 0.0;
    float reflectance = filmed_interface(wo.z, b.eta, film).reflectance;
    return (1.0 - plastic_specular_probability(b, reflectance)) * diffuse_density;
}

vec3 eval_bsdf_plastic(Plastic b, vec3 wo, vec3 wi, Film film, Filmed filmed) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    if (has_weighted_base(b)) return weighted_base_reflection(b, wo, wi, film, filmed);
    float transmitted_o = 1.0 - fresnel_dielectric(wo.z, b.eta).reflectance;
    float transmitted_i = 1.0 - fresnel_dielectric(wi.z, b.eta).reflectance;
    return plastic_base(b) * (INV_PI * wi.z * transmitted_o * transmitted_i);
}

#endif
