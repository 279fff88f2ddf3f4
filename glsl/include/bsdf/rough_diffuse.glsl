// Diffuse reflection by grooves of ideal diffuse facets (Oren and Nayar 1994). The roughness `alpha` is that of Mitsuba
// 0.6: it is comparable to the alpha of a microfacet distribution, and sqrt(2) times the standard deviation of the
// facets' angles. The energy-preserving model (Portsmouth, Kutz and Hill 2024) has a roughness from 0 to 1.
#ifndef BSDF_ROUGH_DIFFUSE_GLSL
#define BSDF_ROUGH_DIFFUSE_GLSL
#include "bsdf/parameters.glsl"
#include "math/direction.glsl"

// Number of the kind.
const uint BSDF_ROUGH_DIFFUSE = 1u;

struct RoughDiffuse {
    COLOR(0) vec3 reflectance;  // albedo, each channel in [0, 1]
    SCALAR(0) float alpha;
    FLAG(MATERIAL_FAST_APPROXIMATION) bool fast_approximation;  // the qualitative model of the paper, without interreflection
    FLAG(MATERIAL_ENERGY_PRESERVING) bool energy_preserving;
};

// What the factor of Fujii's roughness reaches at grazing incidence, and its mean over the hemisphere.
const float FUJII_GRAZING = 0.5 * PI - 2.0 / 3.0;
const float FUJII_MEAN = (2.0 * PI - 5.6) / 3.0;

// Angles of the paper.
struct Grooves {
    float variance;    // sigma^2
    float cos_phi;     // cosine of the difference of the azimuths
    vec2 sine;         // sines of alpha, the larger angle to the normal, and of beta, the smaller
    vec2 cosine;
    vec2 turn;         // 2 alpha / pi, 2 beta / pi
};

Grooves grooves(float alpha, vec3 wo, vec3 wi) {
    Grooves g;
    g.variance = 0.5 * alpha * alpha;
    vec2 sines = vec2(length(wo.xy), length(wi.xy));
    g.cos_phi = clamp(dot(wo.xy, wi.xy) / max(sines.x * sines.y, 1.0e-12), -1.0, 1.0);
    g.sine = wo.z < wi.z ? sines : sines.yx;
    g.cosine = wo.z < wi.z ? vec2(wo.z, wi.z) : vec2(wi.z, wo.z);
    g.turn = atan(g.sine, g.cosine) * (2.0 * INV_PI);
    return g;
}

// Qualitative model of the paper: the largest terms of light that is reflected once.
float groove_reflection_fast(Grooves g) {
    float a = 1.0 - 0.5 * g.variance / (g.variance + 0.33);
    float b = 0.45 * g.variance / (g.variance + 0.09);
    return a + b * max(g.cos_phi, 0.0) * g.sine.x * g.sine.y / max(g.cosine.y, 1.0e-6);
}

// Light that is reflected once.
float groove_reflection(Grooves g) {
    float rough = g.variance / (g.variance + 0.09);
    float c1 = 1.0 - 0.5 * g.variance / (g.variance + 0.33);
    float c2 = 0.45 * rough * (g.sine.x - (g.cos_phi < 0.0 ? g.turn.y * g.turn.y * g.turn.y : 0.0));
    float product = g.turn.x * g.turn.y;
    float c3 = 0.125 * rough * product * product;
    float tan_beta = g.sine.y / max(g.cosine.y, 1.0e-6);
    float tan_half_sum = (g.sine.x + g.sine.y) / max(g.cosine.x + g.cosine.y, 1.0e-6);
    return c1 + g.cos_phi * c2 * tan_beta + (1.0 - abs(g.cos_phi)) * c3 * tan_half_sum;
}

// Light that is reflected from one side of a groove to the other before it leaves.
float groove_interreflection(Grooves g) {
    return 0.17 * g.variance / (g.variance + 0.13) * (1.0 - g.cos_phi * g.turn.y * g.turn.y);
}

// Fujii's form of the qualitative model loses light, even with a reflectance of 1. This is the share of the light from direction `w` that it
// loses, divided by the roughness and by the factor `a` of energy_preserving_reflection. It depends on the direction alone, and is 0 at
// grazing incidence.
float fujii_loss(vec3 w) {
    float sine = min(length(w.xy), 1.0);
    float lost = atan(sine, w.z) - 2.0 / 3.0 - sine * w.z + (2.0 / 3.0) * w.z * (1.0 + sine + sine * sine) / (1.0 + sine);
    return FUJII_GRAZING - sine * lost;
}

// Fujii's form, plus the light that it loses, which leaves the surface after several reflections: f cos. As in Cycles, this light has the color
// once more than in the paper.
vec3 energy_preserving_reflection(vec3 reflectance, float roughness, vec3 wo, vec3 wi) {
    float a = 1.0 / (PI + FUJII_GRAZING * roughness);
    float mean_loss = a * roughness * (FUJII_GRAZING - FUJII_MEAN);
    float s = dot(wo.xy, wi.xy);
    float once = a * (1.0 + roughness * (s > 0.0 ? s / max(wo.z, wi.z) : s));
    // The product of both losses over the mean loss. Without roughness, all of them are 0.
    float again = a * roughness * fujii_loss(wo) * fujii_loss(wi) / (FUJII_GRAZING - FUJII_MEAN);
    vec3 kept = reflectance * reflectance * (1.0 - mean_loss) / (1.0 - reflectance * mean_loss);
    return reflectance * (once + kept * (again * INV_PI)) * wi.z;
}

BsdfSample sample_bsdf_rough_diffuse(RoughDiffuse b, vec3 wo, vec3 u) {
    return BsdfSample(sample_cosine_hemisphere(u.xy), wo.z > 0.0 ? LOBE_DIFFUSE : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_rough_diffuse(RoughDiffuse b, vec3 wo, vec3 wi, float diffuse_density) {
    return wo.z > 0.0 ? diffuse_density : 0.0;
}

vec3 eval_bsdf_rough_diffuse(RoughDiffuse b, vec3 wo, vec3 wi) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    if (has_feature(FEATURE_ENERGY_PRESERVING) && b.energy_preserving) {
        return energy_preserving_reflection(b.reflectance, b.alpha, wo, wi);
    }
    Grooves g = grooves(b.alpha, wo, wi);
    vec3 reflected = b.reflectance * (groove_reflection(g) + b.reflectance * groove_interreflection(g));
    if (b.fast_approximation) reflected = b.reflectance * groove_reflection_fast(g);
    return reflected * (INV_PI * wi.z);
}

#endif
