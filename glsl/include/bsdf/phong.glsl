// Modified Phong model (Lafortune and Willems 1994), as in Mitsuba 0.6's `phong`: a lobe about the mirror direction over
// a diffuse one.
#ifndef BSDF_PHONG_GLSL
#define BSDF_PHONG_GLSL
#include "bsdf/parameters.glsl"
#include "math/direction.glsl"

// Number of the kind.
const uint BSDF_PHONG = 10u;

struct Phong {
    COLOR(0) vec3 diffuse_reflectance;   // albedo of the diffuse part
    COLOR(1) vec3 specular_reflectance;  // factor of the lobe
    SCALAR(0) float exponent;            // exponent of the lobe
    SCALAR(5) float specular_sampling;   // mean albedo of the lobe over that of both parts
};

vec3 mirrored(vec3 wo) {
    return vec3(-wo.xy, wo.z);
}

// cos^n of the angle between `wi` and the mirror direction. The cosine is taken from the chord between both, because a
// large exponent n asks for all its digits.
float phong_power(Phong b, vec3 wo, vec3 wi) {
    vec3 chord = wi - mirrored(wo);
    float cosine = 1.0 - 0.5 * dot(chord, chord);
    return cosine > 0.0 ? pow(cosine, b.exponent) : 0.0;
}

BsdfSample sample_bsdf_phong(Phong b, vec3 wo, vec3 u) {
    if (wo.z <= 0.0) return NO_BSDF_SAMPLE;
    if (u.z >= b.specular_sampling) return BsdfSample(sample_cosine_hemisphere(u.xy), LOBE_DIFFUSE, vec3(0.0), 1.0);
    vec2 d = concentric_disk(u.xy);
    float r2 = dot(d, d);
    float cosine = pow(max(1.0 - r2, 0.0), 1.0 / (b.exponent + 1.0));
    float sine = sqrt(max((1.0 - cosine) * (1.0 + cosine), 0.0));
    vec3 wi = basis_from_normal(mirrored(wo)) * vec3(d * (sine * inversesqrt(max(r2, 1.0e-20))), cosine);
    return BsdfSample(wi, wi.z > 0.0 ? LOBE_GLOSSY : LOBE_NONE, vec3(0.0), 1.0);
}

float pdf_bsdf_phong(Phong b, vec3 wo, vec3 wi, float diffuse_density) {
    if (min(wo.z, wi.z) <= 0.0) return 0.0;
    float lobe = (b.exponent + 1.0) * INV_TWO_PI * phong_power(b, wo, wi);
    return density_of_choice(diffuse_density, lobe, b.specular_sampling);
}

vec3 eval_bsdf_phong(Phong b, vec3 wo, vec3 wi) {
    if (min(wo.z, wi.z) <= 0.0) return vec3(0.0);
    float lobe = (b.exponent + 2.0) * INV_TWO_PI * phong_power(b, wo, wi);
    return (b.specular_reflectance * lobe + b.diffuse_reflectance * INV_PI) * wi.z;
}

#endif
