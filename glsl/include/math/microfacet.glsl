// Microfacet surfaces: the normal distributions of Beckmann and GGX (Walter et al. 2007), Smith masking, and sampling
// of the visible normals (Heitz and d'Eon 2014). The local frame's z-axis is the mean normal. Facet normals have z >=
// 0.
#ifndef MICROFACET_GLSL
#define MICROFACET_GLSL
#include "math/direction.glsl"
#include "shared/records.glsl"
#include "shared/variant.glsl"

struct Microfacets {
    vec2 alpha;  // roughness along x and y
    bool is_ggx; // GGX; otherwise Beckmann
};

Microfacets microfacets(vec2 alpha, bool is_ggx) {
    return Microfacets(max(alpha, vec2(MIN_ALPHA)), is_ggx || !has_feature(FEATURE_BECKMANN));
}

// --------------------------------------------------------------------------------------------------- error function

// erfc(x) exp(x^2) for x >= 0, with a relative error below 3e-6. The fit follows Abramowitz and Stegun 7.1.26.
float scaled_erfc(float x) {
    float t = 1.0 / (1.0 + 0.42 * x);
    return t * (0.23860042 + t * (0.21625674 + t * (0.32137587 + t * (-0.09976038 + t * (0.4907462 - t * 0.16721645)))));
}

// erfc(-x), given exp(-x^2).
float erfc_of_negative(float x, float exp_x2) {
    float tail = scaled_erfc(abs(x)) * exp_x2;
    return x < 0.0 ? tail : 2.0 - tail;
}

// Solution x of erf(x) = 2 u - 1 (Giles 2010, single precision).
float inverse_erf(float u) {
    float w = -log(4.0 * u * (1.0 - u));
    float a = w - 2.5;
    float near = 1.50140941 + a * (0.246640727 + a * (-0.00417768164 + a * (-0.00125372503 + a * (0.000218580870 +
        a * (-4.39150654e-06 + a * (-3.5233877e-06 + a * (3.43273939e-07 + a * 2.81022636e-08)))))));
    float b = sqrt(max(w, 0.0)) - 3.0;
    float far = 2.83297682 + b * (1.00167406 + b * (0.00943887047 + b * (-0.0076224613 + b * (0.00573950773 +
        b * (-0.00367342844 + b * (0.00134934322 + b * (0.000100950558 - b * 0.000200214257)))))));
    return (2.0 * u - 1.0) * (w < 5.0 ? near : far);
}

// ----------------------------------------------------------------------------------------------------- distributions

// D(m): density of facet normals per unit of area and steradian, for m.z >= 0.
float microfacet_density(Microfacets s, vec3 m) {
    vec2 slope = m.xy / s.alpha;
    float slope2 = dot(slope, slope);
    // Beckmann's distribution is 0 at smaller cosines, and GGX hardly changes there.
    float z2 = max(m.z * m.z, 1.0e-9);
    float scale = INV_PI / (s.alpha.x * s.alpha.y);
    if (s.is_ggx) return scale / ((slope2 + z2) * (slope2 + z2));
    return scale * exp(-slope2 / z2) / (z2 * z2);
}

// Projected area of the visible facets along `v`, per unit of mean surface: |cos| / G1 for the exact Smith G1.
float projected_area(Microfacets s, vec3 v) {
    vec2 stretched = s.alpha * v.xy;
    float sin2 = dot(stretched, stretched);
    float c = abs(v.z);
    if (s.is_ggx) return 0.5 * (c + sqrt(c * c + sin2));
    float sine = sqrt(sin2);
    float a = c / max(sine, 1.0e-10 * c + 1.0e-20);
    float exp_a2 = exp(-a * a);
    return 0.5 * (c * erfc_of_negative(a, exp_a2) + sine * exp_a2 * sqrt(INV_PI));
}

// G1(v) / |cos|. For Beckmann, G1 is the rational approximation of Walter et al. (2007), as in Mitsuba.
float masking_per_cosine(Microfacets s, vec3 v) {
    float c = abs(v.z);
    if (s.is_ggx) return 1.0 / max(projected_area(s, v), 1.0e-20);
    float sine = max(length(s.alpha * v.xy), 1.0e-10 * c + 1.0e-20);
    float a = c / sine;
    float rough = (3.535 + 2.181 * a) / (sine * (1.0 + a * (2.276 + a * 2.577)));
    return a < 1.6 ? rough : 1.0 / c;
}

// --------------------------------------------------------------------------------------------------- visible normals

// Visible normal of a stretched GGX surface of roughness 1, seen from direction `v` (Dupuy and Benyoub 2023).
vec3 sample_visible_ggx(vec3 v, vec2 u) {
    vec2 d = concentric_disk(u);
    float r2 = dot(d, d);
    float k = 1.0 + v.z;
    return vec3(d * sqrt(max(k * (2.0 - r2 * k), 0.0)) + v.xy, k * (1.0 - r2));
}

// Slope along the plane of incidence with density proportional to max(c - x s, 0) exp(-x^2), by inversion of the
// cumulative distribution. `c` and `s` are the cosine and the sine of the angle of incidence.
float sample_visible_slope(float c, float s, float u) {
    float most = min(c / max(s, 1.0e-6), 6.0);
    float exp_most = exp(-most * most);
    float target = u * (0.886226925 * c * erfc_of_negative(most, exp_most) + 0.5 * s * exp_most);
    // The start value blends the exact solutions at normal and at grazing incidence. Three of Halley's steps reach
    // 2e-5.
    float x = min(mix(inverse_erf(u), -sqrt(-log(u)), s), 0.999 * most);
    for (int i = 0; i < 3; ++i) {
        float exp_x2 = exp(-x * x);
        float density = max(c - x * s, 1.0e-7);
        float excess = 0.886226925 * c * erfc_of_negative(x, exp_x2) + 0.5 * s * exp_x2 - target;
        float newton = excess / (density * max(exp_x2, 1.0e-30));
        x = min(x - newton / clamp(1.0 + newton * (x + 0.5 * s / density), 0.5, 2.0), most);
    }
    return x;
}

vec3 sample_visible_beckmann(vec3 v, vec2 u) {
    u = clamp(u, vec2(1.0e-7), vec2(1.0 - 1.0e-7));
    float sine = length(v.xy);
    vec2 along = sine > 1.0e-6 ? v.xy / sine : vec2(1.0, 0.0);
    float x = sample_visible_slope(v.z, sine, u.x);
    float y = inverse_erf(u.y);
    return vec3(-x * along + y * vec2(-along.y, along.x), 1.0);
}

// Visible facet normal, with the density D(m) max(v.m, 0) / projected_area(v) per steradian; v.z >= 0.
vec3 sample_visible_normal(Microfacets s, vec3 v, vec2 u) {
    vec3 stretched = normalize(vec3(s.alpha * v.xy, max(v.z, 1.0e-7)));
    vec3 m = s.is_ggx ? sample_visible_ggx(stretched, u) : sample_visible_beckmann(stretched, u);
    return normalize(vec3(s.alpha * m.xy, max(m.z, 1.0e-7)));
}

// ------------------------------------------------------------------------------------------------------------ facets

// Quantities of the facets that lead light from `wi` to `wo` or back. Every BSDF with microfacets needs them.
struct Facet {
    vec3 m;         // normal of the facets, z >= 0
    float density;  // D(m)
    float area;     // projected_area(wo)
    float masking;  // G1(wo) G1(wi) / |cos wo|
};

// Facets between two directions. `eta`, interior over exterior, matters only where the directions lie on different
// sides.
Facet facet_between(Microfacets s, vec3 wo, vec3 wi, float eta) {
    float relative = wo.z > 0.0 ? eta : 1.0 / eta;
    vec3 m = wo + wi * (wo.z * wi.z > 0.0 ? 1.0 : relative);
    m *= inversesqrt(max(dot(m, m), 1.0e-30));
    m = m.z < 0.0 ? -m : m;
    float masking = masking_per_cosine(s, wo) * masking_per_cosine(s, wi) * abs(wi.z);
    return Facet(m, microfacet_density(s, m), max(projected_area(s, wo), 1.0e-20), masking);
}

// Density of the reflected direction `wi`, per steradian, where facet normals are sampled as visible from `wo`.
float reflected_density(Facet f) {
    return f.density / (4.0 * f.area);
}

// f |cos wi| of facets that reflect all light.
float reflected_light(Facet f) {
    return 0.25 * f.density * f.masking;
}

#endif
