// Principled BSDF of a thin sheet (Burley 2015), with the lobes and lobe probabilities of Mitsuba 3's `principledthin`.
// Both sides scatter alike, and light that crosses the sheet is not bent.
#ifndef BSDF_PRINCIPLED_THIN_GLSL
#define BSDF_PRINCIPLED_THIN_GLSL
#include "bsdf/principled.glsl"

// Number of the kind.
const uint BSDF_PRINCIPLED_THIN = 12u;

// Roughness alpha of the facets. Light that crosses is scattered by both faces, so its roughness is another one, which
// depends on the index of refraction.
vec2 principled_thin_alpha(Principled b, bool crosses) {
    float scale = crosses ? 0.65 * b.eta - 0.35 : 1.0;
    return stretched_alpha(scale * b.roughness, b.anisotropic);
}

// Lobe that a number in [0, 1) selects.
struct ThinLobe {
    bool is_specular;  // of the facets; otherwise diffuse
    bool crosses;      // to the other side
};

ThinLobe principled_thin_lobe(Principled b, float u) {
    float specular = b.spec_trans;
    if (u < specular) return ThinLobe(true, u >= 0.5 * specular);
    return ThinLobe(false, u >= specular + principled_brdf(b));
}

// Whether crossing light leaves on the far side of the facet `m`.
bool is_thin_crossing_valid(vec3 wo, vec3 wi, vec3 m) {
    return dot(wi, m) * wo.z < 0.0;
}

// Samples a lobe. `m` is a visible normal.
BsdfSample sample_bsdf_principled_thin(Principled b, vec3 wo, vec3 m, vec3 u) {
    ThinLobe lobe = principled_thin_lobe(b, u.z);
    vec3 scattered = sample_cosine_hemisphere(u.xy);
    if (wo.z < 0.0) scattered.z = -scattered.z;
    vec3 wi = lobe.is_specular ? reflect(-wo, m) : scattered;
    bool valid = wi.z * wo.z > 0.0;
    if (lobe.crosses) wi.z = -wi.z;
    if (lobe.is_specular && lobe.crosses) valid = valid && is_thin_crossing_valid(wo, wi, m);
    return BsdfSample(wi, valid ? LOBE_GLOSSY : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_principled_thin(Principled b, vec3 wo, vec3 wi, Facet f) {
    float side = wo.z * wi.z;
    bool crosses = side < 0.0;
    float specular = crosses && !is_thin_crossing_valid(wo, wi, f.m) ? 0.0 : 0.5 * b.spec_trans;
    float reflecting = principled_brdf(b);
    float diffuse = crosses ? 1.0 - b.spec_trans - reflecting : reflecting;
    float pdf = specular * reflected_density(f) + diffuse * pdf_cosine_hemisphere(abs(wi.z));
    return side != 0.0 ? pdf : 0.0;
}

// Fresnel reflectance of the facets: a dielectric mixed with a tinted one.
vec3 principled_thin_fresnel(Principled b, float cosine, float dielectric) {
    float eta = b.eta;
    float head_on = (eta - 1.0) / (eta + 1.0);
    vec3 tinted = mix(principled_tint(b) * (head_on * head_on), vec3(1.0), schlick_weight_between(cosine, eta));
    return mix(vec3(dielectric), tinted, b.spec_tint);
}

vec3 eval_bsdf_principled_thin(Principled b, vec3 wo, vec3 wi, Facet f) {
    float side = wo.z * wi.z;
    if (side == 0.0) return vec3(0.0);
    float specular = b.spec_trans;
    float cosine = abs(dot(wo, f.m));
    float dielectric = fresnel_dielectric(cosine, b.eta).reflectance;
    if (side < 0.0) {
        float crossing = is_thin_crossing_valid(wo, wi, f.m) ? specular * (1.0 - dielectric) * reflected_light(f) : 0.0;
        float diffuse = (1.0 - specular) * b.metallic * pdf_cosine_hemisphere(abs(wi.z));
        return b.base_color * (crossing + diffuse);
    }
    vec3 value = principled_thin_fresnel(b, cosine, dielectric) * (specular * reflected_light(f));
    value += b.base_color * (principled_brdf(b) * principled_diffuse(b, wo, wi, cosine) * abs(wi.z));
    return value + principled_sheen(b, cosine) * ((1.0 - specular) * abs(wi.z));
}

float guided_part_bsdf_principled_thin(Principled b) {
    if (GUIDE_SET == GUIDE_SET_ALL) return 0.5;
    return 0.0;
}

#endif
