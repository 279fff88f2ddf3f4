// Phase function of a medium: where a point of the medium scatters light to. It has the form of a BSDF without a cosine, and integrates
// to 1. It is a mixture of two lobes, each of which depends on the angle to the direction straight on alone.
#ifndef BSDF_PHASE_GLSL
#define BSDF_PHASE_GLSL
#include "bsdf/parameters.glsl"
#include "math/direction.glsl"

// Number of the kind.
const uint BSDF_PHASE = 15u;

struct Phase {
    SCALAR(0) float mean_cosine0;  // of the first lobe (Henyey and Greenstein 1941), in (-1, 1), or PHASE_RAYLEIGH
    SCALAR(1) float mean_cosine1;  // of the second lobe
    SCALAR(2) float second_lobe;   // probability of the second lobe
};

// Density of a lobe, per steradian. `m` is 1 minus the cosine to the direction straight on, and 1 minus the cosine to the one straight back.
// The one near the lobe's peak is small, and its digits decide.
float phase_lobe(float g, vec2 m) {
    if (g == PHASE_RAYLEIGH) return 3.0 / (16.0 * PI) * (1.0 + (1.0 - m.x) * (1.0 - m.x));
    float size = abs(g);
    float d = (1.0 - size) * (1.0 - size) + 2.0 * size * (g < 0.0 ? m.y : m.x);
    return (1.0 - size) * (1.0 + size) * (0.5 * INV_TWO_PI) / (d * sqrt(d));
}

// 1 minus the cosine of a sample of Rayleigh's lobe: the root of c^3 + 3 c = 4 (2 u - 1), polished by a step of Newton's method.
float sample_rayleigh(float u) {
    float z = 2.0 * (2.0 * u - 1.0);
    float a = pow(abs(z) + sqrt(z * z + 1.0), 1.0 / 3.0);
    float c = sign(z) * (a - 1.0 / a);
    c -= (c * (c * c + 3.0) - 2.0 * z) / (3.0 * (c * c + 1.0));
    return 1.0 - clamp(c, -1.0, 1.0);
}

// 1 minus the cosine of a sample of a lobe to its peak, for g >= 0. The form has no difference of large numbers, and no special case for g = 0.
float sample_phase_lobe(float g, float u) {
    if (g == PHASE_RAYLEIGH) return sample_rayleigh(u);
    float d = 1.0 - g + 2.0 * g * u;
    float s = (1.0 - g) * (1.0 + g) / d;
    return clamp((1.0 - g) * (1.0 - u) * (s + 1.0 - g) / d, 0.0, 2.0);
}

BsdfSample sample_bsdf_phase(Phase b, vec3 wo, vec3 u) {
    float g = u.z < b.second_lobe ? b.mean_cosine1 : b.mean_cosine0;
    float m = sample_phase_lobe(abs(g), u.y);
    vec2 sc = sin_cos_turn(u.x);
    vec3 local = vec3(sqrt(max(m * (2.0 - m), 0.0)) * sc.yx, 1.0 - m);
    return BsdfSample(basis_from_normal(g < 0.0 ? wo : -wo) * local, LOBE_GLOSSY, vec3(0.0), 1.0);
}

float pdf_bsdf_phase(Phase b, vec3 wo, vec3 wi) {
    // The cosines are taken from chords, because a narrow lobe asks for all digits near its peak.
    vec3 on = wi + wo, back = wi - wo;
    vec2 m = min(0.5 * vec2(dot(on, on), dot(back, back)), 2.0);
    return density_of_choice(phase_lobe(b.mean_cosine0, m), phase_lobe(b.mean_cosine1, m), b.second_lobe);
}

vec3 eval_bsdf_phase(Phase b, vec3 wo, vec3 wi) {
    return vec3(pdf_bsdf_phase(b, wo, wi));
}

// A guide draws from the hemisphere about the direction straight on alone, and leaves the other one to the phase function.
float guided_part_bsdf_phase(Phase b) {
    return 0.5;
}

#endif
