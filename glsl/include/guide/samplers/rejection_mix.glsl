// Samplers rejection and rejection-mix: normal-aware rejection sampling of L(cell, w) cos(nb, w), mixed with a uniform
// share, which makes it exact (Kim and Kim 2021, section 4). They are the paper's "Rej+" with the optimal or a given
// share e, and plain rejection, where e is the minimum share. nb is the representative normal of the normal bin, n the
// true normal.
//
// The sampler first chooses a component. The guide proposes directions uniformly on the hemisphere of nb, at most
// MAX_TRIES times. The uniform share, and the fallback after MAX_TRIES failures, draw uniformly from the hemisphere of
// n. Eq. 8 mixes densities: the uniform share is e, and a proposal is accepted with the probability a =
// acceptance_scale L cos+(nb, w). Eq. 9 mixes acceptances: the uniform share is the minimum one, and a =
// acceptance_scale L cos+(nb, w) + e. With the entry's factors the density is
//     guide_scale * L cos+(nb, w)  or  guide_scale * a [nb.w > 0],  plus  uniform_density * [n.w > 0].
// It is positive wherever a surface can reflect.
#ifndef REJECTION_MIX_GLSL
#define REJECTION_MIX_GLSL
#include "guide/samplers/guide.glsl"
#include "random/random.glsl"

// Proposed direction on a hemisphere, and whether the sampler accepts it.
struct Proposal {
    vec3 wi;
    uint bin;
    float radiance;  // radiance of the bin
    bool accepted;
};

// Probability that a proposal on the hemisphere of nb is accepted. `product` is L cos(nb, w).
float acceptance(NormalizationEntry entry, float product) {
    return product * entry.acceptance_scale + (mixes_acceptances() ? entry.uniform_share : 0.0);
}

// Density that the guide contributes to a direction, per steradian. `cosine` is the cosine to nb.
float guide_density(NormalizationEntry entry, float radiance, float cosine) {
    if (mixes_acceptances()) return cosine < 0.0 ? 0.0 : entry.guide_scale * acceptance(entry, radiance * cosine);
    return entry.guide_scale * max(radiance * cosine, 0.0);
}

// Proposes a uniform direction: on the hemisphere of n and accepted as it is, or on that of nb and tested against the
// guide.
Proposal propose(inout RandomStream random, Guide guide, bool take_any) {
    vec2 p = 2.0 * vec2(next_random(random), next_random(random)) - 1.0;
    Proposal s;
    s.wi = map_to_sphere(p);
    if (dot(s.wi, take_any ? guide.n : guide.nb) < 0.0) {
        p = map_antipode(p);
        s.wi = -s.wi;
    }
    s.bin = square_bin(p, DIRECTION_RESOLUTION);
    s.radiance = bin_radiance(guide, s.bin);
    // A threshold below every acceptance replaces a branch.
    float threshold = take_any ? -MAX_DISTANCE : next_random(random);
    s.accepted = threshold < acceptance(guide.entry, s.radiance * dot(s.wi, guide.nb));
    return s;
}

// Takes the first accepted one of several proposals. `tries` counts the proposals up to it.
void take_first(inout Proposal taken, Proposal next, inout uint tries) {
    if (!taken.accepted) {
        taken = next;
        ++tries;
    }
}

GuidedSample sample_rejection_mix(RandomKey key, uint vertex, float choice, Guide guide) {
    RandomStream random = random_stream(key, vertex, RANDOM_TRIES);
    bool uniform_share = choice < (mixes_acceptances() ? MIN_UNIFORM_SHARE : guide.entry.uniform_share);
    // The loop carries the result, and its head tests it: lavapipe 22.3 keeps per lane only what the next iteration
    // reads, and SwiftShader only what the loop's head reads.
    Proposal taken = Proposal(guide.n, 0u, 0.0, false);
    uint tries = 0u;
    while (!taken.accepted && tries <= MAX_TRIES) {
        // Proposals are made in pairs, because a single one would wait for its memory access.
        Proposal first = propose(random, guide, uniform_share || tries == MAX_TRIES);
        Proposal second = propose(random, guide, uniform_share || tries + 1u == MAX_TRIES);
        take_first(taken, first, tries);
        take_first(taken, second, tries);
        if (taken.accepted || tries > MAX_TRIES) break;
    }
    float pdf = guide_density(guide.entry, taken.radiance, dot(taken.wi, guide.nb)) + uniform_density(guide, taken.wi);
    return GuidedSample(taken.wi, pdf, taken.bin, taken.radiance, tries, !taken.accepted);
}

float pdf_rejection_mix(Guide guide, vec3 wi) {
    float radiance = bin_radiance(guide, direction_bin(wi));
    return guide_density(guide.entry, radiance, dot(wi, guide.nb)) + uniform_density(guide, wi);
}

#endif
