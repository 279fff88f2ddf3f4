// The paper's "Rej+" sampler, made exact: a normal-aware rejection sampler of L(cell, w) cos(nb, w), mixed with a uniform
// share (Kim and Kim 2021, section 4 and Eq. 8). nb is the representative normal of the normal's bin, n the true normal.
//
// The component is chosen first. The guide proposes uniformly on the hemisphere of nb, at most MAX_TRIES times; the uniform
// share, and the fallback after that many failures, draw from the hemisphere of n. With the entry's factors the density is
//     guide_scale * L cos+(nb, w) + uniform_density * [n.w > 0],
// and it is positive wherever a surface can reflect.
#ifndef REJECTION_MIX_GLSL
#define REJECTION_MIX_GLSL
#include "equal_area.glsl"
#include "normalization_grid.glsl"
#include "radiance_grid.glsl"
#include "random.glsl"

struct GuidedSample {
    vec3 wi;
    float pdf;      // per steradian
    float radiance; // L of the bin that `wi` lies in
    uint tries;
    bool overrun;   // the driver ended the loop before it came to its end
};

bool is_filled(NormalizationEntry entry) {
    return entry.uniform_density > 0.0;
}

// Share of the density that the guide contributes at a direction with this radiance and cosine.
float guide_density(NormalizationEntry entry, float bin_radiance, float cos_nb) {
    return entry.guide_scale * bin_radiance * max(cos_nb, 0.0);
}

GuidedSample sample_rejection_mix(RandomKey key, uint vertex, float choice, uint cell, vec3 nb, vec3 n,
                                  NormalizationEntry entry) {
    GuidedSample s;
    s.tries = 0u;
    bool uniform_share = choice < entry.uniform_share;
    bool accepted;
    float cos_nb;
    do {
        vec4 u = random4(key, vertex, RANDOM_TRIES + s.tries);
        bool take_any = uniform_share || s.tries == MAX_TRIES;
        vec2 p = 2.0 * u.xy - 1.0;
        s.wi = square_to_sphere(p);
        if (dot(s.wi, take_any ? n : nb) < 0.0) {
            p = antipode(p);
            s.wi = -s.wi;
        }
        s.radiance = radiance(radiance_index(cell, square_bin(p, DIRECTION_RESOLUTION)));
        cos_nb = dot(s.wi, nb);
        accepted = take_any || u.z < s.radiance * cos_nb * entry.acceptance_scale;
        ++s.tries;
    } while (!accepted && s.tries <= MAX_TRIES);
    s.overrun = !accepted;
    s.pdf = guide_density(entry, s.radiance, cos_nb) + entry.uniform_density;
    return s;
}

// Density of `wi`, above the true horizon, under sample_rejection_mix.
float pdf_rejection_mix(uint cell, vec3 nb, vec3 n, vec3 wi, NormalizationEntry entry) {
    float bin_radiance = radiance(radiance_index(cell, direction_bin(wi, DIRECTION_RESOLUTION)));
    return guide_density(entry, bin_radiance, dot(wi, nb)) + (dot(wi, n) > 0.0 ? entry.uniform_density : 0.0);
}

#endif
