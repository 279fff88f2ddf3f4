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
    uint bin;       // direction bin that `wi` lies in
    float radiance; // L of that bin
    uint tries;
    bool overrun;   // the driver ended the loop before it came to its end
};

// A direction on some hemisphere, and whether the sampler takes it.
struct Proposal {
    vec3 wi;
    uint bin;
    float radiance;
    bool accepted;
};

bool is_filled(NormalizationEntry entry) {
    return entry.uniform_density > 0.0;
}

// Share of the density that the guide contributes at a direction with this radiance and cosine.
float guide_density(NormalizationEntry entry, float guide) {
    return entry.guide_scale * max(guide, 0.0);
}

// Uniform on a hemisphere: that of n and taken as it is, or that of nb and tested against the guide.
Proposal propose(inout RandomStream random, uint cell, bool take_any, vec3 nb, vec3 n, NormalizationEntry entry) {
    vec2 p = 2.0 * vec2(next_random(random), next_random(random)) - 1.0;
    Proposal s;
    s.wi = square_to_sphere(p);
    if (dot(s.wi, take_any ? n : nb) < 0.0) {
        p = antipode(p);
        s.wi = -s.wi;
    }
    s.bin = square_bin(p, DIRECTION_RESOLUTION);
    s.radiance = radiance(radiance_index(cell, s.bin));
    // One comparison instead of a branch.
    float threshold = take_any ? -MAX_DISTANCE : next_random(random);
    s.accepted = threshold < s.radiance * dot(s.wi, nb) * entry.acceptance_scale;
    return s;
}

// Of several proposals the first that is accepted counts; `tries` grows by those up to it.
void take_first(inout Proposal taken, Proposal next, inout uint tries) {
    if (!taken.accepted) {
        taken = next;
        ++tries;
    }
}

GuidedSample sample_rejection_mix(RandomKey key, uint vertex, float choice, uint cell, vec3 nb, vec3 n,
                                  NormalizationEntry entry) {
    RandomStream random = random_stream(key, vertex, RANDOM_TRIES);
    bool uniform_share = choice < entry.uniform_share;
    // Carried by the loop, not merely set in it: lavapipe 22.3 keeps per lane only what the next iteration reads, and
    // SwiftShader only what the loop's head does, so that the test stands there.
    Proposal taken = Proposal(n, 0u, 0.0, false);
    uint tries = 0u;
    while (!taken.accepted && tries <= MAX_TRIES) {
        // In pairs, for one proposal alone waits on its memory access.
        Proposal first = propose(random, cell, uniform_share || tries == MAX_TRIES, nb, n, entry);
        Proposal second = propose(random, cell, uniform_share || tries + 1u == MAX_TRIES, nb, n, entry);
        take_first(taken, first, tries);
        take_first(taken, second, tries);
    }
    float pdf = guide_density(entry, taken.radiance * dot(taken.wi, nb)) + entry.uniform_density;
    return GuidedSample(taken.wi, pdf, taken.bin, taken.radiance, tries, !taken.accepted);
}

// Density of `wi`, above the true horizon, under sample_rejection_mix.
float pdf_rejection_mix(uint cell, vec3 nb, vec3 n, vec3 wi, NormalizationEntry entry) {
    float bin_radiance = radiance(radiance_index(cell, direction_bin(wi, DIRECTION_RESOLUTION)));
    return guide_density(entry, bin_radiance * dot(wi, nb)) + (dot(wi, n) > 0.0 ? entry.uniform_density : 0.0);
}

#endif
