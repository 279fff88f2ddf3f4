// Switch over the kinds of BSDF. Directions are unit vectors in the local frame. The local z-axis is the shading
// normal, on the side of `wo` where the surface is two-sided. Each kind has three functions. sample_bsdf_x draws a
// direction. pdf_bsdf_x is the density of that direction per steradian. eval_bsdf_x is f times |cos|. The last two
// functions leave out what is concentrated in single directions.
//
// A guide may sample a diffuse lobe instead of the BSDF. `diffuse_density` is the density of `wi` under the lobe's
// sampler: the guide's density if a guide samples the lobe, otherwise pdf_cosine_hemisphere(wi.z).
#ifndef BSDF_GLSL
#define BSDF_GLSL
#include "bsdf/conductor.glsl"
#include "bsdf/dielectric.glsl"
#include "bsdf/diffuse.glsl"
#include "bsdf/phong.glsl"
#include "bsdf/plastic.glsl"
#include "bsdf/principled.glsl"
#include "bsdf/principled_thin.glsl"
#include "bsdf/rough_conductor.glsl"
#include "bsdf/rough_dielectric.glsl"
#include "bsdf/rough_diffuse.glsl"
#include "bsdf/rough_plastic.glsl"
#include "bsdf/thin_dielectric.glsl"
#include "bsdf/ward.glsl"
#include "bsdf/coating.glsl"

const uint KINDS_WITH_FACETS =
    (1u << BSDF_ROUGH_CONDUCTOR) | (1u << BSDF_ROUGH_DIELECTRIC) | (1u << BSDF_ROUGH_PLASTIC) |
    (1u << BSDF_PRINCIPLED) | (1u << BSDF_PRINCIPLED_THIN);
const Facet NO_FACET = Facet(vec3(0.0, 0.0, 1.0), 0.0, 1.0, 0.0);

bool has_facets() {
    return (MATERIAL_KINDS & KINDS_WITH_FACETS) != 0u;
}

// Facets of the BSDF. `crosses` is true for light that passes to the other side of a thin sheet.
Microfacets bsdf_microfacets(Bsdf b, bool crosses) {
    vec2 alpha = is_kind(b, BSDF_PRINCIPLED) ? principled_alpha(b) : b.scalars0.xy;
    if (is_kind(b, BSDF_PRINCIPLED_THIN)) alpha = principled_thin_alpha(b, crosses);
    return microfacets(alpha, bsdf_flag(b, MATERIAL_GGX));
}

// Facets between `wo` and `wi` of any kind with microfacets. They are evaluated once, because every lane runs through
// all kinds. Facets of a thin sheet reflect also the light that crosses it, which is then mirrored.
Facet bsdf_facet(Bsdf b, vec3 wo, vec3 wi) {
    bool crosses = is_kind(b, BSDF_PRINCIPLED_THIN) && wo.z * wi.z < 0.0;
    if (crosses) wi.z = -wi.z;
    float eta = has_kind(BSDF_ROUGH_DIELECTRIC) || has_kind(BSDF_PRINCIPLED) ? b.scalars0.z : 1.0;
    return has_facets() ? facet_between(bsdf_microfacets(b, crosses), wo, wi, eta) : NO_FACET;
}

vec3 sample_facet(Bsdf b, vec3 wo, vec3 u) {
    bool crosses = is_kind(b, BSDF_PRINCIPLED_THIN) && principled_thin_lobe(b, u.z).crosses;
    return has_facets() ? sample_visible_normal(bsdf_microfacets(b, crosses), wo.z < 0.0 ? -wo : wo, u.xy) : NO_FACET.m;
}

// Albedo for the albedo layer: share of the light that the surface scatters.
vec3 bsdf_albedo(Bsdf b) {
    return b.color0;
}

// Samples a BSDF without its coating. u.xy draws the direction, u.z selects the lobe.
BsdfSample sample_uncoated_bsdf(Bsdf b, vec3 wo, vec3 u) {
    BsdfSample s = NO_BSDF_SAMPLE;
    vec3 m = sample_facet(b, wo, u);
    if (is_kind(b, BSDF_DIFFUSE)) s = sample_bsdf_diffuse(b, wo, u);
    if (is_kind(b, BSDF_ROUGH_DIFFUSE)) s = sample_bsdf_rough_diffuse(b, wo, u);
    if (is_kind(b, BSDF_DIELECTRIC)) s = sample_bsdf_dielectric(b, wo, u);
    if (is_kind(b, BSDF_THIN_DIELECTRIC)) s = sample_bsdf_thin_dielectric(b, wo, u);
    if (is_kind(b, BSDF_ROUGH_DIELECTRIC)) s = sample_bsdf_rough_dielectric(b, wo, m, u);
    if (is_kind(b, BSDF_CONDUCTOR)) s = sample_bsdf_conductor(b, wo, u);
    if (is_kind(b, BSDF_ROUGH_CONDUCTOR)) s = sample_bsdf_rough_conductor(b, wo, m);
    if (is_kind(b, BSDF_PLASTIC)) s = sample_bsdf_plastic(b, wo, u);
    if (is_kind(b, BSDF_ROUGH_PLASTIC)) s = sample_bsdf_rough_plastic(b, wo, m, u);
    if (is_kind(b, BSDF_PRINCIPLED)) s = sample_bsdf_principled(b, wo, m, u);
    if (is_kind(b, BSDF_PHONG)) s = sample_bsdf_phong(b, wo, u);
    if (is_kind(b, BSDF_WARD)) s = sample_bsdf_ward(b, wo, u);
    if (is_kind(b, BSDF_PRINCIPLED_THIN)) s = sample_bsdf_principled_thin(b, wo, m, u);
    return s;
}

float pdf_uncoated_bsdf(Bsdf b, vec3 wo, vec3 wi, float diffuse_density) {
    float pdf = 0.0;
    Facet f = bsdf_facet(b, wo, wi);
    if (is_kind(b, BSDF_DIFFUSE)) pdf = pdf_bsdf_diffuse(b, wo, wi, diffuse_density);
    if (is_kind(b, BSDF_ROUGH_DIFFUSE)) pdf = pdf_bsdf_rough_diffuse(b, wo, wi, diffuse_density);
    if (is_kind(b, BSDF_DIELECTRIC)) pdf = pdf_bsdf_dielectric(b, wo, wi);
    if (is_kind(b, BSDF_THIN_DIELECTRIC)) pdf = pdf_bsdf_thin_dielectric(b, wo, wi);
    if (is_kind(b, BSDF_ROUGH_DIELECTRIC)) pdf = pdf_bsdf_rough_dielectric(b, wo, wi, f);
    if (is_kind(b, BSDF_CONDUCTOR)) pdf = pdf_bsdf_conductor(b, wo, wi);
    if (is_kind(b, BSDF_ROUGH_CONDUCTOR)) pdf = pdf_bsdf_rough_conductor(b, wo, wi, f);
    if (is_kind(b, BSDF_PLASTIC)) pdf = pdf_bsdf_plastic(b, wo, wi, diffuse_density);
    if (is_kind(b, BSDF_ROUGH_PLASTIC)) pdf = pdf_bsdf_rough_plastic(b, wo, wi, diffuse_density, f);
    if (is_kind(b, BSDF_PRINCIPLED)) pdf = pdf_bsdf_principled(b, wo, wi, f);
    if (is_kind(b, BSDF_PHONG)) pdf = pdf_bsdf_phong(b, wo, wi, diffuse_density);
    if (is_kind(b, BSDF_WARD)) pdf = pdf_bsdf_ward(b, wo, wi, diffuse_density);
    if (is_kind(b, BSDF_PRINCIPLED_THIN)) pdf = pdf_bsdf_principled_thin(b, wo, wi, f);
    return pdf;
}

vec3 eval_uncoated_bsdf(Bsdf b, vec3 wo, vec3 wi) {
    vec3 value = vec3(0.0);
    Facet f = bsdf_facet(b, wo, wi);
    if (is_kind(b, BSDF_DIFFUSE)) value = eval_bsdf_diffuse(b, wo, wi);
    if (is_kind(b, BSDF_ROUGH_DIFFUSE)) value = eval_bsdf_rough_diffuse(b, wo, wi);
    if (is_kind(b, BSDF_DIELECTRIC)) value = eval_bsdf_dielectric(b, wo, wi);
    if (is_kind(b, BSDF_THIN_DIELECTRIC)) value = eval_bsdf_thin_dielectric(b, wo, wi);
    if (is_kind(b, BSDF_ROUGH_DIELECTRIC)) value = eval_bsdf_rough_dielectric(b, wo, wi, f);
    if (is_kind(b, BSDF_CONDUCTOR)) value = eval_bsdf_conductor(b, wo, wi);
    if (is_kind(b, BSDF_ROUGH_CONDUCTOR)) value = eval_bsdf_rough_conductor(b, wo, wi, f);
    if (is_kind(b, BSDF_PLASTIC)) value = eval_bsdf_plastic(b, wo, wi);
    if (is_kind(b, BSDF_ROUGH_PLASTIC)) value = eval_bsdf_rough_plastic(b, wo, wi, f);
    if (is_kind(b, BSDF_PRINCIPLED)) value = eval_bsdf_principled(b, wo, wi, f);
    if (is_kind(b, BSDF_PHONG)) value = eval_bsdf_phong(b, wo, wi);
    if (is_kind(b, BSDF_WARD)) value = eval_bsdf_ward(b, wo, wi);
    if (is_kind(b, BSDF_PRINCIPLED_THIN)) value = eval_bsdf_principled_thin(b, wo, wi, f);
    return value;
}

// Whether a coating covers the surface. Specialization makes this false where no material of the scene has a coating.
bool is_coated(Bsdf b) {
    return has_feature(FEATURE_COATING) && bsdf_flag(b, MATERIAL_COATED);
}

// Direction below the coating that corresponds to a direction above it.
CoatedDirection enter_bsdf(Bsdf b, vec3 w) {
    return is_coated(b) ? enter_coating(b.coating, w) : CoatedDirection(w, 0.0);
}

BsdfSample sample_bsdf(Bsdf b, vec3 wo, vec3 u) {
    CoatedDirection entered = enter_bsdf(b, wo);
    float probability = is_coated(b) ? coating_probability(b.coating, entered) : 0.0;
    bool specular = u.z < probability;
    u.z = (u.z - (specular ? 0.0 : probability)) / (specular ? probability : 1.0 - probability);
    BsdfSample s = sample_uncoated_bsdf(b, entered.inside, u);
    if (is_coated(b)) s = sample_coating(b.coating, wo, entered, s, probability, specular);
    return s;
}

float pdf_bsdf(Bsdf b, vec3 wo, vec3 wi, float diffuse_density) {
    CoatedDirection o = enter_bsdf(b, wo);
    CoatedDirection i = enter_bsdf(b, wi);
    if (is_coated(b)) diffuse_density = pdf_cosine_hemisphere(i.inside.z);
    float pdf = pdf_uncoated_bsdf(b, o.inside, i.inside, diffuse_density);
    if (is_coated(b)) pdf *= (1.0 - coating_probability(b.coating, o)) * coating_jacobian(b.coating, wi, i);
    return pdf;
}

vec3 eval_bsdf(Bsdf b, vec3 wo, vec3 wi) {
    CoatedDirection o = enter_bsdf(b, wo);
    CoatedDirection i = enter_bsdf(b, wi);
    vec3 value = eval_uncoated_bsdf(b, o.inside, i.inside);
    if (is_coated(b)) value *= coating_transmittance(b.coating, o, i) * coating_jacobian(b.coating, wi, i);
    return value;
}

#endif
