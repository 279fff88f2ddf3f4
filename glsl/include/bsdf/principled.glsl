// Principled BSDF (Burley 2012 and 2015), with the lobes and lobe probabilities of Mitsuba 3's `principled`.
#ifndef BSDF_PRINCIPLED_GLSL
#define BSDF_PRINCIPLED_GLSL
#include "bsdf/film.glsl"
#include "bsdf/parameters.glsl"
#include "bsdf/rough_dielectric.glsl"
#include "math/constants.glsl"
#include "math/direction.glsl"
#include "math/fresnel.glsl"
#include "math/microfacet.glsl"

// Number of the kind.
const uint BSDF_PRINCIPLED = 9u;

// Parameters of both kinds. All but eta lie in [0, 1].
struct Principled {
    COLOR(0) vec3 base_color;
    SCALAR(0) float roughness;         // square root of the roughness of the facets
    SCALAR(1) float anisotropic;       // stretch of highlights along the tangent
    SCALAR(2) float eta;               // index of refraction, interior over exterior
    SCALAR(4) float metallic;          // share of the metallic model; of a thin sheet: share of the diffuse light that crosses
    SCALAR(5) float spec_trans;        // share of transmission
    SCALAR(6) float spec_tint;         // tint of the specular reflection by the base color
    SCALAR(7) float sheen;             // strength of the sheen at grazing angles
    SCALAR(8) float sheen_tint;        // tint of the sheen by the base color
    SCALAR(9) float flatness;          // blend towards approximate subsurface scattering
    SCALAR(10) float clearcoat;        // strength of the clear coat, which a thin sheet lacks
    SCALAR(11) float clearcoat_gloss;  // gloss of the clear coat
};

// Roughness alpha in the clear coat's masking function.
const float CLEARCOAT_MASKING_ALPHA = 0.25;

// Weight of the diffuse lobe: neither metallic nor transmitting.
float principled_brdf(Principled b) {
    return (1.0 - b.metallic) * (1.0 - b.spec_trans);
}

// Weight of the transmitting lobe.
float principled_bsdf(Principled b) {
    return (1.0 - b.metallic) * b.spec_trans;
}

// Roughness alpha of the facets along and across the tangent, from the parameters.
vec2 stretched_alpha(float roughness, float anisotropic) {
    float aspect = sqrt(1.0 - 0.9 * anisotropic);
    return max(roughness * roughness * vec2(1.0 / aspect, aspect), vec2(0.001));
}

vec2 principled_alpha(Principled b) {
    return stretched_alpha(b.roughness, b.anisotropic);
}

// Base color divided by its luminance.
vec3 principled_tint(Principled b) {
    float brightness = luminance(b.base_color);
    return brightness > 0.0 ? b.base_color / brightness : vec3(1.0);
}

// ---------------------------------------------------------------------------------------------------- reflectances

float schlick_weight(float c) {
    float m = clamp(1.0 - c, 0.0, 1.0);
    return m * m * m * m * m;
}

// Schlick's weight. It uses the angle on the side with the lower refractive index.
float schlick_weight_between(float cos_o, float eta) {
    float relative = cos_o >= 0.0 ? eta : 1.0 / eta;
    float cos_t = sqrt(max(1.0 - (1.0 - cos_o * cos_o) / (relative * relative), 0.0));
    return schlick_weight(relative > 1.0 ? abs(cos_o) : cos_t);
}

// Fresnel reflectance of the facets. From the front it mixes a dielectric, a tinted dielectric and a metal. From behind
// it is the dielectric's reflectance times the weight of the transmitting lobe. A film takes the place of all tints.
vec3 principled_fresnel(Principled b, vec3 wo, float cos_o, vec3 dielectric, Film film, Filmed filmed) {
    float eta = b.eta;
    float relative = cos_o >= 0.0 ? eta : 1.0 / eta;
    float head_on = (relative - 1.0) / (relative + 1.0);
    float weight = schlick_weight_between(cos_o, eta);
    vec3 metal = mix(b.base_color, vec3(1.0), weight);
    vec3 tinted = mix(principled_tint(b) * (head_on * head_on), vec3(1.0), weight);
    vec3 front = mix(mix(dielectric, tinted, b.spec_tint), metal, b.metallic);
    if (is_filmed(film)) front = mix(dielectric, filmed.other, b.metallic);
    return wo.z > 0.0 ? front : principled_bsdf(b) * dielectric;
}

// ------------------------------------------------------------------------------------------------------- clear coat

float clearcoat_alpha(Principled b) {
    return mix(0.1, 0.001, b.clearcoat_gloss);
}

// Density of clear-coat normals per unit of area and steradian: a distribution with longer tails than GGX (Burley 2012,
// gamma = 1).
float clearcoat_density(float alpha, vec3 m) {
    float a2 = alpha * alpha;
    return (a2 - 1.0) * INV_PI / (log(a2) * (dot(m.xy, m.xy) + a2 * m.z * m.z));
}

// Clear-coat normal with the density clearcoat_density times its cosine.
vec3 sample_clearcoat_normal(float alpha, vec2 u) {
    vec2 d = concentric_disk(u);
    float r2 = dot(d, d);
    float a2 = alpha * alpha;
    float sin2 = clamp((pow(a2, 1.0 - r2) - a2) / (1.0 - a2), 0.0, 1.0);
    return vec3(d * sqrt(sin2 / max(r2, 1.0e-20)), sqrt(1.0 - sin2));
}

float clearcoat_masking(vec3 v) {
    float c2 = max(v.z * v.z, 1.0e-12);
    float a2 = CLEARCOAT_MASKING_ALPHA * CLEARCOAT_MASKING_ALPHA;
    return 2.0 / (1.0 + sqrt(1.0 + a2 * max(1.0 / c2 - 1.0, 0.0)));
}

float eval_clearcoat(Principled b, vec3 wo, vec3 wi, vec3 m) {
    float fresnel = mix(0.04, 1.0, schlick_weight_between(dot(wo, m), b.eta));
    float masking = clearcoat_masking(wo) * clearcoat_masking(wi);
    return 0.25 * b.clearcoat * fresnel * clearcoat_density(clearcoat_alpha(b), m) * masking * abs(wi.z);
}

// ---------------------------------------------------------------------------------------------- diffuse and sheen

// Diffuse and retro-reflected light, blended with an approximation of subsurface scattering (Burley 2015).
float principled_diffuse(Principled b, vec3 wo, vec3 wi, float cos_d) {
    float f_o = schlick_weight(abs(wo.z));
    float f_i = schlick_weight(abs(wi.z));
    float retro = 2.0 * b.roughness * cos_d * cos_d;
    float surface = (1.0 - 0.5 * f_o) * (1.0 - 0.5 * f_i) + retro * (f_o + f_i + f_o * f_i * (retro - 1.0));
    float ss = mix(1.0, 0.5 * retro, f_o) * mix(1.0, 0.5 * retro, f_i);
    float below = 1.25 * (ss * (1.0 / max(abs(wo.z) + abs(wi.z), 1.0e-6) - 0.5) + 0.5);
    return INV_PI * mix(surface, below, b.flatness);
}

vec3 principled_sheen(Principled b, float cos_d) {
    float amount = b.sheen * (1.0 - b.metallic) * schlick_weight(abs(cos_d));
    return amount * mix(vec3(1.0), principled_tint(b), b.sheen_tint);
}

// ---------------------------------------------------------------------------------------------------------- triple

// Probabilities of the lobes, given the dielectric's reflectance. From behind, only the facets reflect and transmit.
struct PrincipledLobes {
    float diffuse;
    float clearcoat;
    float transmission;
    float reflection;
};

PrincipledLobes principled_lobes(Principled b, vec3 wo, float dielectric) {
    if (wo.z < 0.0) return PrincipledLobes(0.0, 0.0, 1.0 - dielectric, dielectric);
    float diffuse = principled_brdf(b);
    float clearcoat = 0.25 * b.clearcoat;
    float transmission = principled_bsdf(b) * (1.0 - dielectric);
    float scale = 1.0 / (1.0 + diffuse + clearcoat);
    return PrincipledLobes(diffuse * scale, clearcoat * scale, transmission * scale, (1.0 - transmission) * scale);
}

// Whether the surface is visible from `wo`. From behind it is visible only if it transmits.
bool is_principled_visible(Principled b, vec3 wo) {
    return wo.z > 0.0 || (wo.z < 0.0 && principled_bsdf(b) > 0.0);
}

// Whether each direction lies on the same side of the facet as of the surface.
bool is_facet_compatible(vec3 wo, vec3 wi, vec3 m) {
    return dot(wo, m) * wo.z > 0.0 && dot(wi, m) * wi.z > 0.0;
}

// Samples the principled BSDF. `m` is a visible normal.
BsdfSample sample_bsdf_principled(Principled b, vec3 wo, vec3 m, vec3 u, Film film) {
    float cos_o = dot(wo, m);
    DielectricInterface i = filmed_interface(cos_o, b.eta, film);
    PrincipledLobes lobes = principled_lobes(b, wo, i.reflectance);
    float to_clearcoat = lobes.diffuse + lobes.clearcoat;
    bool crosses = u.z >= to_clearcoat && u.z < to_clearcoat + lobes.transmission;
    if (u.z < to_clearcoat) m = sample_clearcoat_normal(clearcoat_alpha(b), u.xy);
    vec3 refracted = m * (cos_o / i.eta - (cos_o > 0.0 ? i.cos_t : -i.cos_t)) - wo / i.eta;
    vec3 wi = crosses ? refracted : reflect(-wo, m);
    bool valid = is_facet_compatible(wo, wi, m) && (wo.z * wi.z < 0.0) == crosses;
    if (u.z < lobes.diffuse) {
        wi = sample_cosine_hemisphere(u.xy);
        valid = true;
    }
    uint lobe = valid && is_principled_visible(b, wo) ? LOBE_GLOSSY : LOBE_NONE;
    return BsdfSample(wi, lobe, vec3(0.0), crosses ? i.eta : 1.0);
}

float pdf_bsdf_principled(Principled b, vec3 wo, vec3 wi, Facet f, Film film) {
    if (!is_principled_visible(b, wo)) return 0.0;
    float cos_o = dot(wo, f.m);
    float cos_i = dot(wi, f.m);
    DielectricInterface i = filmed_interface(cos_o, b.eta, film);
    PrincipledLobes lobes = principled_lobes(b, wo, i.reflectance);
    float transmitted = f.density / f.area * abs(cos_o * cos_i) * (i.eta * i.eta) * transmitted_jacobian(wo, wi, f.m, i.eta);
    if (wo.z * wi.z <= 0.0) return wo.z * wi.z < 0.0 ? lobes.transmission * transmitted : 0.0;
    float clearcoat = clearcoat_density(clearcoat_alpha(b), f.m) * f.m.z / max(4.0 * abs(cos_i), 1.0e-20);
    float facets = lobes.reflection * reflected_density(f) + lobes.clearcoat * clearcoat;
    return lobes.diffuse * pdf_cosine_hemisphere(wi.z) + (is_facet_compatible(wo, wi, f.m) ? facets : 0.0);
}

// f |cos wi| of light that stays on its side of the surface.
vec3 eval_principled_reflection(Principled b, vec3 wo, vec3 wi, Facet f, float dielectric, Film film, Filmed filmed) {
    vec3 value = vec3(0.0);
    float cos_o = dot(wo, f.m);
    if (is_facet_compatible(wo, wi, f.m)) {
        // Equal refractive indices switch metals off, too, as in Mitsuba.
        vec3 reflectance = is_filmed(film) ? filmed.facet : vec3(dielectric);
        if (b.eta != 1.0) value = principled_fresnel(b, wo, cos_o, reflectance, film, filmed) * reflected_light(f);
        if (wo.z > 0.0) value += eval_clearcoat(b, wo, wi, f.m);
    }
    if (wo.z > 0.0) {
        float cos_d = dot(wi, f.m);
        float diffuse = principled_brdf(b) * principled_diffuse(b, wo, wi, cos_d) * wi.z;
        // The base loses what the film reflects more than the surface without it.
        if (is_filmed(film)) diffuse *= min((1.0 - max_component(filmed.facet)) / max(1.0 - dielectric, 1.0e-6), 1.0);
        value += b.base_color * diffuse;
        value += principled_sheen(b, cos_d) * wi.z;
    }
    return value;
}

vec3 eval_bsdf_principled(Principled b, vec3 wo, vec3 wi, Facet f, Film film, Filmed filmed) {
    if (!is_principled_visible(b, wo)) return vec3(0.0);
    float cos_o = dot(wo, f.m);
    DielectricInterface i = fresnel_dielectric(cos_o, b.eta);
    float side = wo.z * wi.z;
    if (side > 0.0) return eval_principled_reflection(b, wo, wi, f, i.reflectance, film, filmed);
    float transmitted = f.density * f.masking * abs(cos_o * dot(wi, f.m)) * transmitted_jacobian(wo, wi, f.m, i.eta);
    vec3 reflectance = filmed_reflectance(i, film, filmed);
    return side < 0.0 ? sqrt(b.base_color) * (principled_bsdf(b) * (1.0 - reflectance) * transmitted) : vec3(0.0);
}

float guided_part_bsdf_principled(Principled b) {
    if (GUIDE_SET == GUIDE_SET_ALL) return 0.5;
    return 0.0;
}

#endif
