// BSDFs of all kinds, with their coatings and sheens. Directions are unit vectors in the local frame. The local z-axis is the shading normal, on
// the side of `wo` where the surface is two-sided. A kind has up to four functions, which generated/bsdfs.glsl calls.
// sample_bsdf_x draws a direction. pdf_bsdf_x is the density of that direction per steradian. eval_bsdf_x is f times |cos|. Both leave
// out what is concentrated in single directions. guided_part_bsdf_x is the part of the samples in which a guide has a share.
// What depends on a thin film over the surface is `filmed`.
//
// A guide may sample a diffuse lobe instead of the BSDF. `diffuse_density` is the density of `wi` under the lobe's sampler: the guide's
// density if a guide samples the lobe, otherwise pdf_cosine_hemisphere(wi.z).
#ifndef BSDF_GLSL
#define BSDF_GLSL
#include "bsdf/coating.glsl"
#include "bsdf/film.glsl"
#include "bsdf/sheen.glsl"
#include "generated/bsdfs.glsl"
#include "math/thin_film.glsl"

const Facet NO_FACET = Facet(vec3(0.0, 0.0, 1.0), 0.0, 1.0, 0.0);

bool has_facets() {
    return (MATERIAL_KINDS & KINDS_WITH_FACETS) != 0u;
}

// Facets of the BSDF. `crosses` is true for light that passes to the other side of a thin sheet.
Microfacets bsdf_microfacets(Bsdf b, bool crosses) {
    Facets facets = facets_of(b);
    vec2 alpha = vec2(facets.alpha_u, facets.alpha_v);
    if (is_kind(b, BSDF_PRINCIPLED)) alpha = principled_alpha(principled_of(b));
    if (is_kind(b, BSDF_PRINCIPLED_THIN)) alpha = principled_thin_alpha(principled_of(b), crosses);
    return microfacets(alpha, facets.ggx);
}

// Facets between `wo` and `wi` of any kind with microfacets. They are evaluated once, because every lane runs through
// all kinds. Facets of a thin sheet reflect also the light that crosses it, which is then mirrored.
Facet bsdf_facet(Bsdf b, vec3 wo, vec3 wi) {
    bool crosses = is_kind(b, BSDF_PRINCIPLED_THIN) && wo.z * wi.z < 0.0;
    if (crosses) wi.z = -wi.z;
    float eta = has_kind(BSDF_ROUGH_DIELECTRIC) || has_kind(BSDF_PRINCIPLED) ? facets_of(b).eta : 1.0;
    return has_facets() ? facet_between(bsdf_microfacets(b, crosses), wo, wi, eta) : NO_FACET;
}

vec3 sample_facet(Bsdf b, vec3 wo, vec3 u) {
    bool crosses = is_kind(b, BSDF_PRINCIPLED_THIN) && principled_thin_lobe(principled_of(b), u.z).crosses;
    return has_facets() ? sample_visible_normal(bsdf_microfacets(b, crosses), wo.z < 0.0 ? -wo : wo, u.xy) : NO_FACET.m;
}

// Whether all that the BSDF reflects in single directions is reflected by the whole surface, not by facets.
bool is_smooth(Bsdf b) {
    return is_kind(b, BSDF_CONDUCTOR) || is_kind(b, BSDF_DIELECTRIC) || is_kind(b, BSDF_PLASTIC);
}

// Reflectances of a surface under a film whose facets are met at this cosine. They are found once for all kinds. From behind, a dielectric
// reflects as from the front at the angle to which light is refracted.
Filmed film_over(Bsdf b, vec3 wo, float cos_facet) {
    bool is_principled = is_kind(b, BSDF_PRINCIPLED);
    bool is_metal = is_kind(b, BSDF_CONDUCTOR) || is_kind(b, BSDF_ROUGH_CONDUCTOR);
    mat2x3 index = is_metal ? mat2x3(b.color1, b.color2) : mat2x3(vec3(facets_of(b).eta), vec3(0.0));
    float cos_o = cos_facet >= 0.0 ? cos_facet : fresnel_dielectric(cos_facet, index[0].x).cos_t;
    int count = is_principled || is_kind(b, BSDF_PLASTIC) || is_kind(b, BSDF_ROUGH_PLASTIC) ? 2 : 1;
    Filmed filmed = NO_FILMED;
    for (int i = 0; i < count; ++i) {
        vec3 reflectance = film_reflectance(cos_o, b.film.eta, b.film.thickness, index[0], index[1]);
        if (i == 0) filmed.facet = reflectance;
        filmed.other = reflectance;
        if (is_principled) index = metal_index(b.color0);
        else cos_o = wo.z;
    }
    return filmed;
}

// Whether the BSDF is a plastic whose base has a weight.
bool is_weighted_plastic(Bsdf b) {
    return (is_kind(b, BSDF_PLASTIC) || is_kind(b, BSDF_ROUGH_PLASTIC)) && has_weighted_base(plastic_of(b));
}

// Albedo for the albedo layer: share of the light that the surface scatters.
vec3 bsdf_albedo(Bsdf b) {
    vec3 albedo = b.color0;
    if (is_weighted_plastic(b)) albedo = weighted_base(plastic_of(b));
    if (is_kind(b, BSDF_HAIR)) albedo = albedo_of_hair(hair_of(b));
    return has_feature(FEATURE_SHEEN) ? b.sheen_lobe.kept * albedo + b.sheen_lobe.albedo : albedo;
}

// Whether radiance that crosses the surface does not change with the index of refraction, as in Cycles.
bool is_unscaled(Bsdf b) {
    return has_feature(FEATURE_UNSCALED) && bsdf_flag(b, MATERIAL_UNSCALED);
}

// The sample of an unscaled BSDF, from that of its kind.
BsdfSample without_scaling(Bsdf b, BsdfSample s) {
    if (is_unscaled(b)) s = BsdfSample(s.wi, s.lobe, s.weight * (s.eta * s.eta), 1.0);
    return s;
}

// Samples a BSDF without its coating and its sheen. u.xy draws the direction, u.z selects the lobe.
BsdfSample sample_uncoated_bsdf(Bsdf b, vec3 wo, vec3 u) {
    Filmed filmed = NO_FILMED;
    if (is_filmed(b.film) && is_smooth(b)) filmed = film_over(b, wo, wo.z);
    return without_scaling(b, sample_bsdf_of_kind(b, wo, sample_facet(b, wo, u), u, filmed));
}

float pdf_uncoated_bsdf(Bsdf b, vec3 wo, vec3 wi, float diffuse_density) {
    return pdf_bsdf_of_kind(b, wo, wi, diffuse_density, bsdf_facet(b, wo, wi));
}

vec3 eval_uncoated_bsdf(Bsdf b, vec3 wo, vec3 wi) {
    Facet f = bsdf_facet(b, wo, wi);
    Filmed filmed = NO_FILMED;
    if (is_filmed(b.film)) filmed = film_over(b, wo, is_smooth(b) ? wo.z : dot(wo, f.m));
    vec3 value = eval_bsdf_of_kind(b, wo, wi, f, filmed);
    if (is_unscaled(b) && wo.z * wi.z < 0.0) {
        float eta = facets_of(b).eta;
        value *= wo.z > 0.0 ? eta * eta : 1.0 / (eta * eta);
    }
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
    if (has_feature(FEATURE_SHEEN)) probability = max(probability, b.sheen_lobe.probability);
    bool of_layer = u.z < probability;
    u.z = (u.z - (of_layer ? 0.0 : probability)) / (of_layer ? probability : 1.0 - probability);
    BsdfSample s = sample_uncoated_bsdf(b, entered.inside, u);
    if (is_coated(b)) s = sample_coating(b.coating, wo, entered, s, probability, of_layer);
    if (has_feature(FEATURE_SHEEN) && bsdf_flag(b, MATERIAL_SHEEN)) {
        s.weight *= b.sheen_lobe.kept / (1.0 - probability);
        if (of_layer) s = sample_sheen(b.sheen_lobe, u.xy);
    }
    return s;
}

float pdf_bsdf(Bsdf b, vec3 wo, vec3 wi, float diffuse_density) {
    CoatedDirection o = enter_bsdf(b, wo);
    CoatedDirection i = enter_bsdf(b, wi);
    if (is_coated(b)) diffuse_density = pdf_cosine_hemisphere(i.inside.z);
    float pdf = pdf_uncoated_bsdf(b, o.inside, i.inside, diffuse_density);
    if (is_coated(b)) pdf *= (1.0 - coating_probability(b.coating, o)) * coating_jacobian(b.coating, wi, i);
    if (has_feature(FEATURE_SHEEN)) pdf = density_of_choice(pdf, pdf_sheen(b.sheen_lobe, wi), b.sheen_lobe.probability);
    return pdf;
}

vec3 eval_bsdf(Bsdf b, vec3 wo, vec3 wi) {
    CoatedDirection o = enter_bsdf(b, wo);
    CoatedDirection i = enter_bsdf(b, wi);
    vec3 value = eval_uncoated_bsdf(b, o.inside, i.inside);
    if (is_coated(b)) value *= coating_transmittance(b.coating, o, i) * coating_jacobian(b.coating, wi, i);
    if (has_feature(FEATURE_SHEEN)) value = b.sheen_lobe.kept * value + pdf_sheen(b.sheen_lobe, wi) * b.sheen_lobe.albedo;
    return value;
}

#endif
